#pragma once
// One result from the passes of a point.
//
// A pass has few periods, so its own standard error is uncertain. Weights from it alone would favour the
// passes whose error came out small, and the error of the mean would be too small (10 passes of 5 periods:
// +-2 errors cover 86 %). Therefore, for k passes of n_i periods with nu_i = n_i - 1 degrees of freedom:
// - s_i: standard error of pass i without the widening for few periods
// - c n_i^-p: its expected square. p: from the passes, between 1 (drift jitters) and 3 (positions are noisy)
// - S_i^2 = (nu_i s_i^2 + 20 c n_i^-p) / (nu_i + 20)
// - v = sum w_i v_i / sum w_i, with w_i = 1 / S_i^2
// - chi2 = sum w_i (v_i - v)^2 / (k - 1)
// - sigma = few_periods_factor(sum nu_i) max(1, sqrt(chi2)) / sqrt(sum w_i)
//
// +-2 sigma covers 95 to 98 % when the passes agree. When they scatter 1.4 times as much as their errors say,
// it covers about 90 %: k passes determine a scatter only to 1/sqrt(2 (k - 1)).
#include <limits>
#include <span>
#include <vector>

#include "calibration/estimate.hpp"

namespace shaker::reduction {

/// Drift velocity of a pass, as a reduction gives it, and its number of periods.
struct PassDrift {
    calibration::Estimate v_D;
    int periods = 0;
};

struct CombinedDrift {
    calibration::Estimate v_D;    // NaN without passes
    std::vector<double> weights;  // of the passes; their sum is 1. 0: a pass without a finite error
    double chi2 = std::numeric_limits<double>::quiet_NaN();  // per degree of freedom; NaN for one pass
};
/// One pass keeps its numbers to the bit.
CombinedDrift combined(std::span<const PassDrift> passes);

/// Mean with these weights. sigma: that of the values, widened by sqrt(chi2) where they scatter more than it.
calibration::Estimate weighted(std::span<const calibration::Estimate> values,
                               std::span<const double> weights);
/// The same for angles, rad: differences from the first one count modulo 2 pi.
calibration::Estimate weighted_angle(std::span<const calibration::Estimate> angles,
                                     std::span<const double> weights);

}  // namespace shaker::reduction

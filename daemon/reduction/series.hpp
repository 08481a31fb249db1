#pragma once
// Results from several measurements: repeats as one result, drift without the effect of tilt, null phase.
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "calibration/estimate.hpp"
#include "drivers/drive.hpp"

namespace shaker::reduction {

/// One measurement: requested drive and results.
struct DrivenPoint {
    Drive asked;
    calibration::Estimate gamma, phi, v_D;
};

/// The same biharmonic drive at phi + pi.
bool mirrored(const Drive& a, const Drive& b);

/// A point and the newest earlier one with the same drive at phi + pi. By symmetry, the drift on a level
/// bench changes its sign.
struct MirrorPair {
    /// (v(phi) - v(phi + pi)) / 2 at the newer point's phi, m/s: without the effect of tilt.
    calibration::Estimate drift;
    calibration::Estimate common;  // (v(phi) + v(phi + pi)) / 2, m/s: zero on a level bench
};
/// For the newest point; empty until its partner (phi + pi) has been measured. Points in order of time.
std::optional<MirrorPair> mirror_pair(std::span<const DrivenPoint> points);

/// The null of v_D with dv_D/dphi < 0.
struct NullPhase {
    calibration::Estimate phi0;   // rad
    calibration::Estimate theta;  // phi0 - pi/2, rad
};
/// Linear interpolation between the newest point and a neighbour in phi on the other side of the null, at
/// most `widest_bracket` away, with the same drive and rho = 1/2. sigma includes the errors of v_D and the
/// possible curvature over the bracket. Empty without such a pair.
std::optional<NullPhase> null_phase(std::span<const DrivenPoint> points);
inline constexpr double widest_bracket = 0.175;  // rad

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
/// One result from the passes of a point, or from repeats. One pass keeps its numbers to the bit.
///
/// A pass has few periods, so its own standard error is uncertain. Weights from it alone would favour the
/// passes whose error came out small, and the error of the mean would be too small (10 passes of 5 periods:
/// +-2 errors cover 86 %). Therefore, for k passes of n_i periods with nu_i = n_i - 1 degrees of freedom:
/// - s_i: standard error of pass i without the widening for few periods
/// - c n_i^-p: its expected square. p: from the passes, between 1 (drift jitters) and 3 (positions are noisy)
/// - S_i^2 = (nu_i s_i^2 + 20 c n_i^-p) / (nu_i + 20)
/// - v = sum w_i v_i / sum w_i, with w_i = 1 / S_i^2
/// - chi2 = sum w_i (v_i - v)^2 / (k - 1)
/// - sigma = few_periods_factor(sum nu_i) max(1, sqrt(chi2)) / sqrt(sum w_i)
///
/// +-2 sigma covers 95 to 98 % when the passes agree. When they scatter 1.4 times as much as their errors
/// say, it covers about 90 %: k passes determine a scatter only to 1/sqrt(2 (k - 1)).
CombinedDrift combined(std::span<const PassDrift> passes);

/// Mean with these weights. sigma: that of the values, widened by sqrt(chi2) where they scatter more than it.
calibration::Estimate weighted(std::span<const calibration::Estimate> values,
                               std::span<const double> weights);
/// The same for angles, rad: differences from the first one count modulo 2 pi.
calibration::Estimate weighted_angle(std::span<const calibration::Estimate> angles,
                                     std::span<const double> weights);

}  // namespace shaker::reduction

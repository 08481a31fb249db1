#pragma once
// What the shaker did, in the paper's words, with errors.
#include <span>
#include <vector>

#include "calibration/harmonic_fit.hpp"
#include "daemon/reduction/reduction.hpp"

namespace shaker {

struct DriveMeasured {
    Estimate gamma, rho, phi;  // A1 + A2, A1/(A1 + A2), alpha2 - 2 alpha1 in (-pi, pi]
    Estimate v_rms;            // m/s
    std::vector<MeasuredHarmonic> harmonics;
};

/// From the fit of the base's acceleration (m/s^2); errors by its whole covariance. With one harmonic only,
/// the second counts as zero and phi is NaN.
DriveMeasured drive_measured(const HarmonicFit& acceleration);

/// gamma and phi of each period from t0 on that has at least 90 % of the usual samples, by least squares of
/// harmonics 1 and 2 on what the whole run's fit leaves there. k counts from t0; drift and frames are not
/// set.
std::vector<PeriodResult> drive_by_period(const HarmonicFit& acceleration, std::span<const double> t_s,
                                          std::span<const double> a_mps2, double t0_s);

}  // namespace shaker

#pragma once
// Motion of the base in the paper's quantities, with errors.
#include <span>
#include <vector>

#include "calibration/harmonics/harmonic_fit.hpp"
#include "daemon/reduction/aligner.hpp"
#include "daemon/reduction/reduction.hpp"

namespace shaker::reduction {

struct BaseMotion {
    calibration::Estimate gamma, rho,
        phi;                      // A1 + A2 (m/s^2), A1/(A1 + A2), alpha2 - 2 alpha1 in (-pi, pi] (rad)
    calibration::Estimate v_rms;  // m/s
    std::vector<MeasuredHarmonic> harmonics;
};

/// From the fit of the base's acceleration (m/s^2); errors from its full covariance. With one harmonic only,
/// A2 = 0 and phi is NaN.
BaseMotion drive_measured(const calibration::HarmonicFit& acceleration);

/// The drive's frequency over the fit's, where two or more harmonics move the base and their orders have a
/// common divisor: 2 for a drive of 20 and 40 Hz that is called one of 10 Hz. Else 1.
int times_too_low(const calibration::HarmonicFit& acceleration);

/// gamma and phi of each period from t0 on that has at least 90 % of the usual number of samples. Least
/// squares of harmonics 1 and 2 on the residuals of the whole run's fit. k counts from t0; drift and frames
/// are not set.
std::vector<PeriodResult> drive_by_period(const calibration::HarmonicFit& acceleration,
                                          std::span<const double> t_s, std::span<const double> a_mps2,
                                          double t0_s);

/// Sets MeasuredHarmonic::across, with errors from the scatter across the axis.
void measure_across(const Alignment& drive, int axes, std::vector<MeasuredHarmonic>& harmonics);

}  // namespace shaker::reduction

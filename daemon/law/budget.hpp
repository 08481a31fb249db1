#pragma once
// Budgets: the contributions to the standard uncertainty of each mu.
#include <span>
#include <string>
#include <vector>

#include "daemon/law/coulomb_fit.hpp"
#include "daemon/law/slope_mu.hpp"

namespace shaker::law {

/// Standard uncertainties of the inputs that no scatter shows. The defaults are estimates for a bench as in
/// WIRING.md, not measurements: replace them by those of the bench's calibration.
struct InputErrors {
    double gain =
        1e-3;  // accelerometer's scale along the axis, relative: tumble calibration of a MEMS sensor
    double scale = 5e-4;    // camera's scale, relative: a printed board
    double tilt = 5e-4;     // rad, where the tilt is not fitted: a machinist's level
    double clock = 2e-5;    // rate of master time, relative: a quartz
    double gravity = 2e-4;  // local g, relative: 9.8 m/s^2 from latitude and height to 2 mm/s^2
};

struct Share {
    std::string source;  // statistics, gain, scale, tilt, harmonics, clock, local g
    double share = 0;    // relative standard uncertainty of mu by this source
    std::string input;   // uncertainty behind it, for people
};

struct Budget {
    std::string of;               // name of the fit
    std::vector<Share> shares{};  // largest first
    double value = NAN;           // mu
    double total = 0;             // root of the sum of squares, relative
};

/// mu_ac: by the weights of the fit. statistics: errors of v_D. harmonics: errors of the measured harmonics
/// and of the push. tilt: what the fitted tilt adds, or tilt's own error where it is not fitted. An error of
/// the clock acts on v_D and on the frequency.
Budget coulomb_budget(std::span<const Point> points, const CoulombFit& fit, const InputErrors& errors);
/// mu_k = a/g of slips: proportional to the camera's scale, to 1/T^2 and to 1/g; free of the accelerometer.
Budget slope_budget(const SlopeFit& fit, const InputErrors& errors);
/// mu_ns: proportional to gamma/g at given nulls; free of the camera's scale and of the clock. nulls: those
/// of the fit.
Budget no_stick_budget(const Fit& fit, std::span<const Fit> nulls, const InputErrors& errors);

}  // namespace shaker::law

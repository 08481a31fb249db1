#pragma once
// Tilt of the base from gravity, and its share of v_D.
#include <array>
#include <optional>
#include <span>

#include "calibration/accelerometer/tumble.hpp"
#include "calibration/estimate.hpp"
#include "calibration/harmonics/harmonic_fit.hpp"

namespace shaker::reduction {

/// The accelerometer's fits with the shaker's axis.
struct SensorFits {
    const calibration::HarmonicFit* along = nullptr;          // m/s^2; constant: - g sin(tilt) + offset
    std::array<const calibration::HarmonicFit*, 2> across{};  // on across_axes(axis)
    std::array<double, 3> axis{};                             // unit vector in sensor axes
    bool axis_from_motion = false;                            // else it is exact
    const std::optional<calibration::Tumble>* calibration = nullptr;
};

/// Angle between the shaker's axis and the horizontal, positive: +x points downhill. From the mean
/// acceleration along the axis over that of all axes.
struct Tilt {
    calibration::Estimate angle;  // rad; sigma: noise, axis and calibration; NaN: the offset is not known
    double noise = NAN;           // rad, the part of sigma by noise and axis
    calibration::Estimate v_D;    // m/s, part of v_D that the tilt causes
    double mu = NAN;              // with this friction coefficient
};

/// The angle. NaN when gravity is not in the reading (mean acceleration outside 9 to 10.6 m/s^2).
Tilt tilt_of(const SensorFits& sensor);

/// Friction coefficient by the walker's deceleration in slip: median of -sgn(v - v_base) dv/dt over the
/// phases at which the walker slides, over g. Good to a few percent; NaN without slip. phase: 0..1.
double friction_in_slip(std::span<const double> phase, std::span<const double> v,
                        std::span<const double> v_base, double frequency_hz);

/// Sets the share of v_D: by Coulomb's law with `mu` on the measured base, v_D at this tilt minus v_D on a
/// level base. Its error contains that of the angle and 10 % of the share for the law and mu. Remains NaN
/// where the law misses the measured v_D by more than a tenth of gamma/omega. v_D falls and rises with the
/// tilt at rates that differ by up to three, because a stick appears on one side.
void set_share(Tilt& tilt, const calibration::HarmonicFit& acceleration, double mu, double v_D);

}  // namespace shaker::reduction

#pragma once
// Motion of the base across the shaker's axis, from a three-axis accelerometer.
#include <array>
#include <complex>

#include "calibration/estimate.hpp"

namespace shaker::calibration {

/// Two unit vectors that form a right-handed set with `axis` (of any length); zero if the axis has length 0.
std::array<std::array<double, 3>, 2> across_axes(const std::array<double, 3>& axis) noexcept;

/// One harmonic of the motion across the axis, relative to that along it: r_k = across_k / along for the two
/// across_axes(). share^2 = |r_1|^2 + |r_2|^2. In phase: sensor or shaker misaligned; where the axis was
/// derived from the motion itself, harmonics 1 and 2 define it and have almost none. Quadrature: the base
/// rocks, or its guide gives way. Three axes of acceleration at one place do not show a rotation about it or
/// the centre of a rotation.
struct Transverse {
    Estimate
        amplitude;   // root of the sum of squares over the two axes; noise alone gives about twice its sigma
    Estimate share;  // amplitude / amplitude along the axis; not significant where that is noise
    double in_phase = 0;                // hypot(Re r_1, Re r_2)
    double quadrature = 0;              // hypot(Im r_1, Im r_2); share^2 = in_phase^2 + quadrature^2
    std::array<double, 3> direction{};  // unit vector in sensor axes, direction of the strongest motion; its
                                        // largest component is positive
};

/// along: amplitude on the axis; across: on its across_axes(); all for one harmonic and in one unit. sd: of
/// each real and imaginary part; NaN where a direction across is not measured: then nothing is known.
Transverse transverse(std::complex<double> along, const std::array<std::complex<double>, 2>& across,
                      const std::array<double, 3>& axis, double sd) noexcept;

}  // namespace shaker::calibration

#pragma once
// How a base moves across the shaker's axis, by a sensor of three axes.
#include <array>
#include <complex>

#include "calibration/estimate.hpp"

namespace shaker {

/// Two unit vectors that make a right-handed set with an axis of any length; zero for an axis of length 0.
std::array<std::array<double, 3>, 2> across_axes(const std::array<double, 3>& axis) noexcept;

/// One harmonic of the motion across the axis, beside that along it. In phase: a sensor or a shaker
/// that is not aligned; where the axis was found from the motion itself, harmonics 1 and 2 define it and have
/// little of it. In quadrature: the base rocks or its guide gives way. At the sensor this is all that three
/// axes of acceleration tell: turning about it, and where the centre of turning lies, they do not.
struct Transverse {
    Estimate amplitude;     // root of the sum over the two axes; noise alone makes twice its sigma
    Estimate share;         // of the amplitude along the axis; means little where that is noise
    double in_phase = 0;    // of the share, at the two axes together
    double quadrature = 0;  // likewise: share^2 = in_phase^2 + quadrature^2
    std::array<double, 3> direction{};  // unit vector in sensor axes along which it is strongest, its largest
                                        // component positive
};

/// along: amplitude on the axis; across: on its across_axes(), all of one harmonic and in one unit; sd: of
/// each of their real and imaginary parts.
Transverse transverse(std::complex<double> along, const std::array<std::complex<double>, 2>& across,
                      const std::array<double, 3>& axis, double sd) noexcept;

}  // namespace shaker

#include "calibration/accelerometer/transverse.hpp"

#include <algorithm>
#include <cmath>

namespace shaker::calibration {

namespace {

using Vector = std::array<double, 3>;

Vector cross(const Vector& a, const Vector& b) noexcept {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

Vector unit(Vector a) noexcept {
    const double length = std::hypot(a[0], a[1], a[2]);
    if (length > 0)
        for (double& x : a) x /= length;
    return a;
}

bool smaller(double a, double b) noexcept { return std::abs(a) < std::abs(b); }

}  // namespace

std::array<Vector, 2> across_axes(const Vector& axis) noexcept {
    const Vector u = unit(axis);
    Vector aside{};
    aside[static_cast<std::size_t>(std::ranges::min_element(u, smaller) - u.begin())] = 1;
    const Vector first = unit(cross(u, aside));
    return {first, cross(u, first)};
}

Transverse transverse(std::complex<double> along, const std::array<std::complex<double>, 2>& across,
                      const Vector& axis, double sd) noexcept {
    if (std::isnan(sd)) return {.amplitude = {}, .share = {}, .in_phase = NAN, .quadrature = NAN};
    const std::array r{across[0] / along, across[1] / along};
    const double share = std::sqrt(std::norm(r[0]) + std::norm(r[1]));
    Transverse t{.amplitude = {std::hypot(std::abs(across[0]), std::abs(across[1])), sd},
                 .share = {share, sd / std::abs(along) * std::hypot(1, share)},
                 .in_phase = std::hypot(r[0].real(), r[1].real()),
                 .quadrature = std::hypot(r[0].imag(), r[1].imag())};
    // Direction of the ellipse's longer axis.
    const double angle =
        0.5 * std::atan2(2 * (r[0] * std::conj(r[1])).real(), std::norm(r[0]) - std::norm(r[1]));
    const auto [first, second] = across_axes(axis);
    for (std::size_t k = 0; k < 3; ++k)
        t.direction[k] = std::cos(angle) * first[k] + std::sin(angle) * second[k];
    if (*std::ranges::max_element(t.direction, smaller) < 0)
        for (double& x : t.direction) x = -x;
    return t;
}

}  // namespace shaker::calibration

#pragma once
// A real trigonometric polynomial of a phase, and the phases at which it changes sign.
#include <array>
#include <cmath>
#include <complex>
#include <cstddef>
#include <vector>

#include "drivers/drive.hpp"

namespace shaker {

/// Cosine and sine of a phase.
struct Turn {
    double c = 1;
    double s = 0;
};
inline Turn turn(double phase) noexcept { return {std::cos(phase), std::sin(phase)}; }

/// The turn at phase + delta; exact to rounding for |delta| <= 1e-4 rad.
inline Turn nudged(Turn z, double delta) noexcept {
    const double c = 1 - delta * delta / 2, s = delta * (1 - delta * delta / 6);
    return {z.c * c - z.s * s, z.s * c + z.c * s};
}

/// value(theta) = mean + sum_{q=1..order} (in_phase[q-1] sin q theta + quadrature[q-1] cos q theta).
struct TrigPolynomial {
    double mean = 0;
    int order = 0;
    std::array<double, max_harmonics> in_phase{};
    std::array<double, max_harmonics> quadrature{};

    TrigPolynomial() = default;
    /// mean + Im sum a_q e^{i q theta}.
    TrigPolynomial(double mean_value, const std::array<std::complex<double>, max_harmonics>& a) noexcept;

    [[nodiscard]] double operator()(Turn z) const noexcept {
        double sum = mean;
        Turn power = z;
        for (std::size_t q = 0; q < static_cast<std::size_t>(order); ++q) {
            sum += in_phase[q] * power.s + quadrature[q] * power.c;
            power = {power.c * z.c - power.s * z.s, power.s * z.c + power.c * z.s};
        }
        return sum;
    }
    [[nodiscard]] double operator()(double phase) const noexcept {
        return order == 0 ? mean : (*this)(turn(phase));
    }
    [[nodiscard]] TrigPolynomial derivative() const noexcept;
    /// Upper bound of |value - mean| of the n-th derivative: sum q^n |a_q|.
    [[nodiscard]] double bound(int n) const noexcept;
};

/// All phases in [0, 2 pi) where f changes sign, increasing, exact to rounding. Roots at which f touches
/// zero without a change of sign are left out. Two roots are separated down to 1e-8 rad.
std::vector<double> sign_changes(const TrigPolynomial& f);

}  // namespace shaker

#pragma once
// The excitation: the requested Drive, and complex amplitudes at f, 2f, ...
#include <array>
#include <cmath>
#include <complex>
#include <numbers>

#include "drivers/quantity.hpp"

namespace shaker {

inline constexpr double two_pi = 2 * std::numbers::pi;
inline constexpr int max_harmonics = 16;

/// Value of the unit g, m/s^2, in every input and every output: "1.5g" is 1.5 times this. The paper's value.
inline constexpr double paper_g = 9.8;

/// Complex amplitudes of a periodic signal: value(t) = Im sum_{q=1..16} a[q-1] e^{i q w t}, so |a| is the
/// peak amplitude of a harmonic and arg(a) its phase against sin(q w t). `Unit` keeps volts and m/s^2 apart.
template <class Unit>
struct Harmonics {
    std::array<std::complex<double>, max_harmonics> a{};
    [[nodiscard]] std::complex<double>& at(int q) { return a.at(static_cast<std::size_t>(q - 1)); }
    [[nodiscard]] const std::complex<double>& at(int q) const {
        return a.at(static_cast<std::size_t>(q - 1));
    }
    /// Highest q with a non-zero amplitude, 0 when silent.
    [[nodiscard]] int order() const noexcept {
        int q = max_harmonics;
        while (q > 0 && a[static_cast<std::size_t>(q - 1)] == 0.0) --q;
        return q;
    }
    bool operator==(const Harmonics&) const = default;
};
struct Voltage;       // V at the DAC's output
struct Acceleration;  // m/s^2 of the base along the shaker's axis

inline constexpr int most_driven = 8;  // highest harmonic of the drive frequency that can be requested

/// Requested motion of the base: a_B = gamma [rho sin wt + (1-rho) sin(2wt + phi)], the paper's Eq. (1),
/// plus optional overtones.
struct Drive {
    double frequency = 20.0;  // Hz
    double gamma = paper_g;   // m/s^2
    double rho = 0.5;         // 0..1
    double phi = 0.0;         // rad
    std::array<std::complex<double>, most_driven - 2>
        overtones{};  // complex amplitudes of harmonics 3 to 8, as shares of gamma

    [[nodiscard]] bool biharmonic() const noexcept {
        return overtones == std::array<std::complex<double>, most_driven - 2>{};
    }
    bool operator==(const Drive&) const = default;
};

/// The drive as harmonics of the base acceleration.
inline Harmonics<Acceleration> harmonics(const Drive& d) {
    Harmonics<Acceleration> h;
    h.at(1) = d.gamma * d.rho;
    h.at(2) = std::polar(d.gamma * (1 - d.rho), d.phi);
    for (std::size_t i = 0; i < d.overtones.size(); ++i) h.a[i + 2] = d.gamma * d.overtones[i];
    return h;
}

/// Value of the signal at a phase in rad; one period is 2 pi.
template <class Unit>
double value_at(const Harmonics<Unit>& h, double phase) noexcept {
    const std::complex<double> z = std::polar(1.0, phase);
    std::complex<double> sum = 0;
    for (int q = max_harmonics; q >= 1; --q) sum = (sum + h.a[static_cast<std::size_t>(q - 1)]) * z;
    return sum.imag();
}

/// gamma, rho and phi of harmonics 1 and 2, with the time origin where harmonic 1 has phase 0: gamma = A1
/// + A2, rho = A1 / gamma, phi = alpha2 - 2 alpha1 wrapped to (-pi, pi].
inline Drive drive_of(const Harmonics<Acceleration>& h, double frequency) {
    const double a1 = std::abs(h.at(1)), a2 = std::abs(h.at(2));
    const double phi = std::remainder(std::arg(h.at(2)) - 2 * std::arg(h.at(1)), two_pi);
    return {frequency, a1 + a2, a1 + a2 > 0 ? a1 / (a1 + a2) : 0.0, phi, {}};
}

/// Allowed ranges of a requested run, SI units; both ends included. Command line, settings, SCPI and web page
/// share them.
struct DriveLimits {
    Range frequency{1, 1000};
    Range gamma{0.01, 100 * paper_g};
    Range rho{0, 1};
    Range phi{-2 * two_pi, 2 * two_pi};
    Range share{0, 1};  // amplitude of an overtone, as a share of gamma
    Range mains{0, 1000};
};
inline constexpr DriveLimits drive_limits{};
/// Friction coefficient that an operator gives.
inline constexpr Range allowed_friction{0.005, 3};

}  // namespace shaker

#include "daemon/safety/preflight.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>

#include "drivers/errors.hpp"
#include "drivers/trig_polynomial.hpp"

namespace shaker::safety {

namespace {

using Amplitudes = std::array<std::complex<double>, max_harmonics>;

// The extremes are at the sign changes of the derivative.
double largest(const Amplitudes& a) {
    const TrigPolynomial value{0, a};
    double peak = 0;
    for (const double phase : sign_changes(value.derivative())) peak = std::max(peak, std::abs(value(phase)));
    return peak;
}

double rounded_down(double value, double step) { return step * std::floor(value / step); }

}  // namespace

double largest_displacement(const Harmonics<Acceleration>& motion, double frequency) {
    Amplitudes displacement{};
    for (std::size_t k = 0; k < max_harmonics; ++k) {
        const double w = two_pi * frequency * static_cast<double>(k + 1);
        displacement[k] = -motion.a[k] / (w * w);
    }
    return largest(displacement);
}

std::vector<Demand> demands(const PlannedMotion& motion, const Limits& limits) {
    Amplitudes velocity{}, volts{};
    for (std::size_t k = 0; k < max_harmonics; ++k) {
        const std::complex<double> a = motion.target.a[k];
        if (a == 0.0) continue;
        const std::complex<double> jw{0, two_pi * motion.frequency * static_cast<double>(k + 1)};
        velocity[k] = a / jw;
        volts[k] = a / motion.response[k];
        if (!std::isfinite(std::abs(volts[k])))
            throw InputError{fmt::format("the shaker's response at harmonic {}, {:.6g} Hz, is unknown", k + 1,
                                         static_cast<double>(k + 1) * motion.frequency)};
    }
    const double acceleration = largest(motion.target.a);
    return {{"acceleration", acceleration, limits.acceleration.abort, "m/s^2"},
            {"velocity", largest(velocity), limits.velocity.abort, "m/s"},
            {"displacement", 1e3 * largest_displacement(motion.target, motion.frequency),
             1e3 * limits.displacement.abort, "mm"},
            {"force", motion.moving_kg * acceleration, limits.force_n, "N"},
            {"drive", largest(volts), limits.drive.abort, "V"}};
}

void require_within(const std::vector<Demand>& demands, double gamma) {
    std::string beyond;
    double least = 1;
    for (const Demand& d : demands) {
        if (!d.beyond()) continue;
        beyond += fmt::format("{}{} peak {:.4g} {} (limit {:.4g} {})", beyond.empty() ? "" : ", ", d.quantity,
                              d.value, d.unit, d.limit, d.unit);
        least = std::min(least, d.limit / d.value);
    }
    if (!beyond.empty())
        throw InputError{fmt::format(
            "the drive exceeds the limits: {}; at most gamma {:.4g} m/s^2 ({:.3g} g) is allowed for this "
            "shape",
            beyond, rounded_down(gamma * least, 1e-3), rounded_down(gamma * least / paper_g, 1e-2))};
}

}  // namespace shaker::safety

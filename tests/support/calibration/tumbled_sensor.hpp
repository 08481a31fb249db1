#pragma once
// An accelerometer with known errors that is held in attitudes.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include "calibration/accelerometer/tumble.hpp"

namespace shaker::test {

using calibration::Counts;
using calibration::Vector;

/// Counts = round(scale^-1 (gain f + offset + noise)) with f the specific force; each axis of `gain` near
/// one.
struct TumbledSensor {
    double gravity = 9.8123;                // m/s^2
    double mps2_per_count = 78.5 / 524288;  // 20 bits over +-8 g
    calibration::Matrix gain{{{1.021, 0.006, -0.004}, {-0.003, 0.987, 0.008}, {0.005, 0.002, 1.013}}};
    Vector offset{0.31, -0.22, 0.12};  // m/s^2
    double noise = 245e-6;             // m/s^2 per root Hz: 25 ug
    double rate_hz = 400;
    double hold_s = 2;
    double held_within = 2;  // deg, rms of each angle
    std::mt19937_64 random{7};

    [[nodiscard]] Vector nominal() const { return {mps2_per_count, mps2_per_count, mps2_per_count}; }

    /// Specific force in an attitude: gravity along its name, turned by a random small angle.
    Vector held(std::string_view name) {
        std::normal_distribution<double> angle{0, held_within * std::numbers::pi / 180};
        Vector up = *direction_of(name);
        const Vector w{angle(random), angle(random), angle(random)};
        const Vector turned{up[0] + w[1] * up[2] - w[2] * up[1], up[1] + w[2] * up[0] - w[0] * up[2],
                            up[2] + w[0] * up[1] - w[1] * up[0]};
        const double length = std::hypot(turned[0], turned[1], turned[2]);
        for (std::size_t k = 0; k < 3; ++k) up[k] = gravity * turned[k] / length;
        return up;
    }
    [[nodiscard]] Counts counts(const Vector& force) {
        std::normal_distribution<double> white{0, noise * std::sqrt(rate_hz / 2)};
        Counts c{};
        for (std::size_t k = 0; k < 3; ++k) {
            const double a = gain[k][0] * force[0] + gain[k][1] * force[1] + gain[k][2] * force[2];
            c[k] = static_cast<std::int32_t>(std::lround((a + offset[k] + white(random)) / mps2_per_count));
        }
        return c;
    }
    /// One held record. turn: deg, by which the sensor turns about z during it.
    std::vector<Counts> record(std::string_view name, double turn = 0) {
        const Vector f = held(name);
        std::vector<Counts> samples(static_cast<std::size_t>(hold_s * rate_hz));
        for (std::size_t i = 0; i < samples.size(); ++i) {
            const double a =
                turn * std::numbers::pi / 180 * static_cast<double>(i) / static_cast<double>(samples.size());
            samples[i] = counts(
                {f[0] * std::cos(a) - f[1] * std::sin(a), f[0] * std::sin(a) + f[1] * std::cos(a), f[2]});
        }
        return samples;
    }
    template <class Names>
    std::vector<calibration::Attitude> attitudes(const Names& names) {
        std::vector<calibration::Attitude> all;
        for (const std::string_view name : names)
            all.push_back(calibration::attitude_of(std::string{name}, record(name)));
        return all;
    }
};

}  // namespace shaker::test

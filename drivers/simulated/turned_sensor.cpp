#include "drivers/simulated/turned_sensor.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <random>
#include <sstream>

#include "drivers/attitude/attitude.hpp"

namespace shaker::simulated {

namespace {

using Vector = std::array<double, 3>;

Vector cross(const Vector& a, const Vector& b) noexcept {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

Vector scaled_to(double length, Vector a) noexcept {
    const double by = length / std::hypot(a[0], a[1], a[2]);
    for (double& x : a) x *= by;
    return a;
}

}  // namespace

std::vector<std::string> words_of(const std::string& text) {
    std::istringstream in{text};
    return {std::istream_iterator<std::string>{in}, {}};
}

TurnedSensor::TurnedSensor(const Scene& scene)
    : hold_s_{scene.accelerometer.hold_s},
      turn_s_{scene.accelerometer.turn_s},
      gravity_{scene.gravity},
      up_{{0, 0, 1}} {
    std::mt19937_64 random{scene.seed * 2654435761U + 131};
    std::normal_distribution<double> angle{
        0, std::max(scene.accelerometer.held_within_deg, 1e-12) * std::numbers::pi / 180};
    for (const std::string& name : words_of(scene.accelerometer.attitudes)) {
        Vector up = *direction_of(name);
        const double x = angle(random), y = angle(random), z = angle(random);
        const Vector by = cross({x, y, z}, up);
        for (std::size_t k = 0; k < 3; ++k) up[k] += by[k];
        up_.push_back(scaled_to(1, up));
    }
}

Vector TurnedSensor::force(double t) const noexcept {
    const double turns = std::max(t - hold_s_, 0.0) / (turn_s_ + hold_s_);
    const auto last = std::min(static_cast<std::size_t>(turns), up_.size() - 1);
    const auto next = std::min(last + 1, up_.size() - 1);
    const double s = std::min((turns - static_cast<double>(last)) * (turn_s_ + hold_s_) / turn_s_, 1.0);
    // From one direction to the next by the side, so that opposite ones have a way too.
    const Vector &a = up_[last], &b = up_[next], aside = cross(a, {0.48, 0.6, 0.64});
    Vector up{};
    for (std::size_t k = 0; k < 3; ++k)
        up[k] = (1 - s) * a[k] + s * b[k] + s * (1 - s) * aside[k] * (last == next ? 0 : 1);
    return scaled_to(gravity_, up);
}

}  // namespace shaker::simulated

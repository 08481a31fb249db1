#pragma once
// TurnedSensor: an accelerometer off the base that is held in one attitude after the other.
#include <array>
#include <string>
#include <vector>

#include "drivers/simulated/scene.hpp"

namespace shaker::simulated {

/// The words of a text.
std::vector<std::string> words_of(const std::string& text);

/// Lies with z up for hold_s, then is turned for turn_s and held for hold_s in each attitude of the scene;
/// stays in the last one.
class TurnedSensor {
public:
    explicit TurnedSensor(const Scene& scene);
    /// True if the scene has attitudes.
    [[nodiscard]] bool turned() const noexcept { return up_.size() > 1; }
    /// Specific force in the sensor's axes at true time t, m/s^2.
    [[nodiscard]] std::array<double, 3> force(double t) const noexcept;

private:
    double hold_s_, turn_s_, gravity_;
    std::vector<std::array<double, 3>> up_;  // unit vectors, with the errors of the hand
};

}  // namespace shaker::simulated

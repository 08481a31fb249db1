#pragma once
// Names of the attitudes of a three-axis sensor at rest: which of its axes points up.
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string_view>

namespace shaker {

/// The six faces and twelve edges of a cube, in the order in which an operator is led: "+x" when the sensor's
/// x axis points up, "+x-y" when the direction between +x and -y does.
inline constexpr std::array<std::string_view, 18> standard_attitudes{
    "+x",   "-x",   "+y",   "-y",   "+z",   "-z",   "+x+y", "+x-y", "-x+y",
    "-x-y", "+x+z", "+x-z", "-x+z", "-x-z", "+y+z", "+y-z", "-y+z", "-y-z"};

/// Unit vector that points up, in the sensor's axes; corners ("+x+y-z") are names too. Empty for other texts.
inline std::optional<std::array<double, 3>> direction_of(std::string_view attitude) noexcept {
    std::array<double, 3> up{};
    if (attitude.size() % 2 != 0 || attitude.empty()) return std::nullopt;
    for (std::size_t i = 0; i < attitude.size(); i += 2) {
        const std::size_t axis = std::string_view{"xyz"}.find(attitude[i + 1]);
        if ((attitude[i] != '+' && attitude[i] != '-') || axis > 2 || up[axis] != 0) return std::nullopt;
        up[axis] = attitude[i] == '+' ? 1 : -1;
    }
    const double length = std::hypot(up[0], up[1], up[2]);
    for (double& x : up) x /= length;
    return up;
}

}  // namespace shaker

#pragma once
// Which of the counts' axes is which of the sensor's, from the names of attitudes.
#include <span>
#include <string>
#include <vector>

#include "calibration/accelerometer/tumble.hpp"

namespace shaker::calibration {

/// A signed permutation: the sensor's axis i is the counts' axis from[i] times sign[i].
struct AxisOrder {
    std::array<std::size_t, 3> from{0, 1, 2};
    std::array<double, 3> sign{1, 1, 1};
    [[nodiscard]] Vector operator()(const Vector& of_counts) const noexcept {
        return {sign[0] * of_counts[from[0]], sign[1] * of_counts[from[1]], sign[2] * of_counts[from[2]]};
    }
    /// "axes x and y are exchanged", "axis z is reversed", ...; empty for the identity.
    [[nodiscard]] std::string sentence() const;
};

/// The order that fits the names best; the identity if fewer than six attitudes have one. directions: of up,
/// in the counts' axes. InputError names an attitude farther than same_attitude from its name.
AxisOrder axis_order(std::span<const Attitude> attitudes, std::span<const Vector> directions);

}  // namespace shaker::calibration

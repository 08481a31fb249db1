#pragma once
// Gravity as an accelerometer at rest measures it.
#include <cmath>

namespace shaker::safety {

inline constexpr double most_gravity_off =
    0.4;  // largest relative error of gravity with which a bench may drive

/// True when a sensor at rest that measures `seen` has not the gain of its rig file: not the gravity of the
/// place, m/s^2. A smaller mean is the offset of a sensor that does not measure gravity.
inline bool gravity_wrong(double seen, double gravity) noexcept {
    constexpr double least_gravity = 0.5;  // m/s^2
    return seen >= least_gravity && std::abs(seen / gravity - 1) >= most_gravity_off;
}

}  // namespace shaker::safety

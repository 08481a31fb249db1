#pragma once
// Grip: the accelerations that friction gives a walker, constant during one sample of the plant.
#include <algorithm>

namespace shaker::simulated {

/// All in m/s^2. Kinetic friction works against the slip; a law without stick gives it with its own sign and
/// has no static friction.
struct Grip {
    double forward = 0, backward = 0;            // kinetic, in forward and in backward slip
    double hold_forward = 0, hold_backward = 0;  // static, against a release into that slip

    [[nodiscard]] double kinetic(int slip) const noexcept { return slip < 0 ? backward : forward; }
    /// Static friction for the acceleration that a walker at rest on the base needs.
    [[nodiscard]] double hold(double needed) const noexcept {
        return needed > 0 ? hold_backward : hold_forward;
    }
    [[nodiscard]] double most_hold() const noexcept { return std::max(hold_forward, hold_backward); }
};

}  // namespace shaker::simulated

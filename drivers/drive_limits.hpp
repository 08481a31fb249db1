#pragma once
// Allowed ranges of a requested run. Command line, settings, SCPI and web page share them.
#include "drivers/drive.hpp"
#include "drivers/quantity.hpp"

namespace shaker {

/// SI units; both ends included.
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

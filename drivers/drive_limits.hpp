#pragma once
// What a run may be asked for, by any of the ways to ask.
#include "drivers/drive.hpp"
#include "drivers/quantity.hpp"

namespace shaker {

/// SI; both ends included.
struct DriveLimits {
    Range frequency{1, 1000};
    Range gamma{0.01, 100 * paper_g};
    Range rho{0, 1};
    Range phi{-2 * two_pi, 2 * two_pi};
    Range share{0, 1};  // of gamma, in an overtone
    Range mains{0, 1000};
};
inline constexpr DriveLimits drive_limits{};
inline constexpr int most_periods = 1'000'000;
inline constexpr int most_settle_periods = 10'000;

}  // namespace shaker

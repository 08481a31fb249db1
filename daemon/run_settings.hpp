#pragma once
// The settings of a run as TOML: what `--settings` reads and what a recording keeps.
#include <filesystem>
#include <string>

#include "daemon/commands.hpp"
#include "drivers/quantity.hpp"

namespace shaker {

/// What a run may be asked for; SI.
struct DriveLimits {
    Range frequency{1, 1000};
    Range gamma{0.01, 100 * paper_g};
    Range rho{0, 1};
    Range phi{-2 * two_pi, 2 * two_pi};
    Range mains{0, 1000};
};
inline constexpr DriveLimits drive_limits{};
inline constexpr int most_periods = 1'000'000;

/// Changes `options` by the table [run] of a file: rig, scene, frequency_hz, gamma_mps2, rho, phi_rad,
/// periods, frames, identify, closed_loop,
/// mains_hz. InputError with file, line, key, value and range for anything else.
void read_run_settings(const std::filesystem::path& file, RunOptions& options);

/// The settings of a run as such a file. The scene is not in it: a recording keeps that as a whole.
std::string run_settings_text(const RunOptions& options);

}  // namespace shaker

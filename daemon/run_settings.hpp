#pragma once
// The settings of a run as TOML: what `--settings` reads and what a recording keeps.
#include <filesystem>
#include <string>

#include "daemon/commands.hpp"
#include "drivers/drive_limits.hpp"
#include "drivers/settings_table.hpp"

namespace shaker {

/// Changes `options` by a table: rig, scene and what a run takes. InputError with file, line, key, value and
/// range for anything else.
void read_run_table(SettingsTable run, RunOptions& options);

/// Changes `options` by the table [run] of a file: rig, scene, frequency_hz, gamma_mps2, rho, phi_rad,
/// [[run.harmonic]] n (3..8), share, phase_rad; periods, settle_periods, frames, identify, closed_loop,
/// mains_hz. InputError with file, line, key, value and range for anything else.
void read_run_settings(const std::filesystem::path& file, RunOptions& options);

/// The settings of a run as such a file. The scene is not in it: a recording keeps that as a whole.
std::string run_settings_text(const RunOptions& options);

}  // namespace shaker

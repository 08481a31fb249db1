#pragma once
// The settings of a run as TOML: what `--settings` reads and what a recording keeps.
#include <filesystem>
#include <string>

#include "drivers/drive.hpp"
#include "drivers/drive_limits.hpp"
#include "drivers/recorded/recording_file.hpp"
#include "drivers/settings_table.hpp"

namespace shaker::run {

struct RunOptions {
    std::string rig = "sim:";
    std::filesystem::path scene;  // empty: the paper's bench
    Drive drive;
    int periods = 40;
    int settle = 0;             // periods of the settled drive before them; 0: until the walker is steady
    std::filesystem::path out;  // empty: nothing is recorded
    std::filesystem::path trips = ".";  // folder for the last seconds of a stopped run that is not recorded
    recorded::KeptPictures pictures = recorded::KeptPictures::region;
    bool identify = true;     // find out the response before; else the data sheet's is taken
    bool closed_loop = true;  // measured harmonics correct the drive
    double mains_hz = 0;      // fitted beside the harmonics; 0: not
    bool threads = false;     // one thread a loop instead of lockstep
    bool real_time = false;   // with threads, a simulated rig is no faster than a real one
    bool json = false;
};

/// Changes `options` by a table: rig, scene and what a run takes. InputError with file, line, key, value and
/// range for anything else.
void read_run_table(SettingsTable run, RunOptions& options);

/// Changes `options` by the table [run] of a file: rig, scene, frequency_hz, gamma_mps2, rho, phi_rad,
/// [[run.harmonic]] n (3..8), share, phase_rad; periods, settle_periods, frames, identify, closed_loop,
/// mains_hz. InputError with file, line, key, value and range for anything else.
void read_run_settings(const std::filesystem::path& file, RunOptions& options);

/// The settings of a run as such a file. The scene is not in it: a recording keeps that as a whole.
std::string run_settings_text(const RunOptions& options);

}  // namespace shaker::run

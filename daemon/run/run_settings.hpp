#pragma once
// The settings of a run as TOML: what `--settings` reads and what a recording keeps.
#include <cmath>
#include <filesystem>
#include <string>

#include "calibration/estimate.hpp"
#include "drivers/drive.hpp"
#include "drivers/point_fields.hpp"
#include "drivers/recorded/recording_file.hpp"
#include "drivers/settings_table.hpp"
#include "drivers/simulated/scene.hpp"

namespace shaker::run {

struct RunOptions {
    std::string rig = "sim:";
    std::filesystem::path scene;                           // file; empty: the paper's bench
    simulated::Scene standard = simulated::paper_scene();  // the simulated bench that `scene` changes
    Drive drive;
    MeasurementPlan plan;               // `measurements` is of a bench on call
    std::filesystem::path out;          // empty: nothing is recorded
    std::filesystem::path trips = ".";  // folder for the last seconds of a stopped run that is not recorded
    recorded::KeptPictures pictures = recorded::KeptPictures::first_second;
    bool identify = true;     // measure the response first; false: use the data sheet's response
    bool closed_loop = true;  // measured harmonics correct the drive
    double mains_hz = 0;      // mains frequency, fitted together with the harmonics; 0: where it is found
    bool threads = false;     // one thread for each loop; false: lockstep
    bool real_time = false;   // with threads: a simulated rig keeps to real time
    bool json = false;
    bool uncommissioned = false;  // drive a bench without a record of its commissioning, at half its limits
    /// Friction coefficient of walker and base, for the predicted walk before a single run; NaN: not known.
    calibration::Estimate mu{NAN, NAN};
};

/// Changes `options` by a table with the keys listed at read_run_settings(). InputError with file, line, key,
/// value and range for anything else.
void read_run_table(SettingsTable run, RunOptions& options);

/// Changes `options` by the table [run] of a file: rig, scene, frequency_hz, gamma_mps2, rho, phi_rad,
/// [[run.harmonic]] n (3..8), share, phase_rad; periods, settle_periods, frames, identify, closed_loop,
/// mains_hz. InputError with file, line, key, value and range for anything else.
void read_run_settings(const std::filesystem::path& file, RunOptions& options);

/// The settings of a run as the text of such a file, without the scene: a recording keeps the scene file
/// itself.
std::string run_settings_text(const RunOptions& options);

}  // namespace shaker::run

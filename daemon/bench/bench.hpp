#pragma once
// Bench: an opened rig with data sheet, limits and response.
#include <complex>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/safety/limits.hpp"
#include "drivers/commissioned/record.hpp"
#include "drivers/drive.hpp"
#include "drivers/simulated/world.hpp"

namespace shaker::bench {

/// An opened rig and its properties known before the first sample.
struct Bench {
    std::unique_ptr<simulated::World> world;  // simulated rig only; outlives `rig`
    Rig rig;
    simulated::Scene scene;                  // simulated rig only
    simulated::ShakerTruth shaker;           // data sheet of shaker and amplifier
    double gravity = paper_g;                // m/s^2 at the place
    safety::Limits limits;                   // in force for every run
    std::string rig_text;                    // TOML: the rig file, or the scene of a simulated rig
    std::vector<commissioned::Named> files;  // that the rig file names, and the mixers of the sound cards
    bool real_time_required = false;   // nothing is driven without real-time scheduling and locked memory
    std::string not_commissioned;      // reason why it may not be driven; empty: it may
    bool halved = false;               // its limits are halved, also after a reload
    std::vector<std::string> granted;  // requested and granted settings of the devices, one sentence each
    /// Response of the shaker from the data sheet, m/s^2 per V, at a frequency in Hz.
    std::function<std::complex<double>(double)> response;
};

/// Opens a rig. "sim:" is the simulated rig: `standard`, modified by the file `scene` (may be empty). Any
/// other name is a rig file: its devices (hardware_rig.hpp) and [shaker], the data sheet of shaker and
/// amplifier. Both may have [limits] (limits.hpp); limits that are not given follow from the data sheet. Both
/// may have gravity_mps2, the gravity of the place (default 9.8), and a calibration file of the
/// accelerometer. A rig file must name the shaker: its model, or all that the limits follow from (ratings,
/// coil, amplifier, masses); real_time = "wanted" allows a drive without real-time scheduling. InputError for
/// the file's content, DeviceError for a device that cannot be opened.
Bench open_bench(const std::string& name, const std::filesystem::path& scene, simulated::World::Pace pace,
                 const simulated::Scene& standard = simulated::paper_scene());

/// Changes of the mixers of the sound cards since the bench was opened. A mixer that cannot be read
/// counts as one control.
commissioned::MixerChange mixers_changed(const Bench& bench);
/// What differs, at the opening, from the mixers in the record of the commissioning; empty: nothing, or there
/// is no record that can be read.
std::string mixers_off_record(const Bench& bench);
/// Sets the mixers of real devices as in the record of the commissioning. Returns what was set. InputError
/// when no record has them, DeviceError.
std::vector<std::string> restore_mixers(Bench& bench);

/// The limits in the bench's file now, for a reload.
struct NewLimits {
    safety::Limits limits;
    std::vector<std::string> ignored;  // other keys and tables of the file that have changed
};
/// Reads the file again; the devices are not touched. InputError for its content, and for a rig file that the
/// record of the commissioning does not cover.
NewLimits limits_now(const Bench& bench, const std::string& name, const std::filesystem::path& scene);

/// Keys and tables of the top level that the texts do not both have with the same values, sorted. InputError
/// for a text that is not TOML.
std::vector<std::string> changed_settings(std::string_view before, std::string_view after);

}  // namespace shaker::bench

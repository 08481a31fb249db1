#pragma once
// The rigs a run can be opened on, by name.
#include <complex>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "daemon/control/limits.hpp"
#include "drivers/simulated/world.hpp"

namespace shaker {

/// An opened rig and what is known of it before the first sample.
struct OpenRig {
    std::unique_ptr<World> world;  // of a simulated rig; outlives `rig`
    Rig rig;
    Scene scene;                       // of a simulated rig
    ShakerTruth shaker;                // data sheet of shaker and amplifier, of any rig
    Limits limits;                     // what may not be exceeded, of any rig
    std::string rig_text;              // TOML: of real devices their file, of a simulated rig its scene
    std::vector<std::string> granted;  // what the devices were asked for and gave, one sentence each
    /// The shaker's response by its data sheet, m/s^2 a volt, at a frequency.
    std::function<std::complex<double>(double)> response;
};

/// "sim:" is the simulated rig; `scene` (may be empty) changes it. Any other name is a rig file: the devices
/// it names (hardware_rig.hpp) and [shaker], the data sheet of shaker and amplifier. Both may have [limits]
/// (limits.hpp); what it does not say follows from the data sheet. InputError for what is
/// in the file, DeviceError for a device that cannot be opened.
OpenRig open_rig(const std::string& name, const std::filesystem::path& scene, World::Pace pace);

/// The limits of this bench as its files say now, for a reload; the devices stay as they are.
Limits limits_now(const OpenRig& bench, const std::string& name, const std::filesystem::path& scene);

}  // namespace shaker

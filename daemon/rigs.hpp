#pragma once
// The rigs a run can be opened on, by name.
#include <array>
#include <complex>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "drivers/drive.hpp"
#include "drivers/simulated/world.hpp"

namespace shaker {

/// An opened rig and what is known of it before the first sample.
struct OpenRig {
    std::unique_ptr<World> world;  // of a simulated rig; outlives `rig`
    Rig rig;
    Scene scene;                       // of a simulated rig
    std::vector<std::string> granted;  // what the devices were asked for and gave, one sentence each
    /// The shaker's response by its data sheet, m/s^2 a volt, at f, 2f, ...
    std::array<std::complex<double>, max_harmonics> response{};
};

/// "sim:" is the simulated rig; `scene` (may be empty) changes it. InputError for a name that is not known.
OpenRig open_rig(const std::string& name, const std::filesystem::path& scene, double frequency,
                 World::Pace pace);

}  // namespace shaker

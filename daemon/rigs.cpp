#include "daemon/rigs.hpp"

#include "drivers/errors.hpp"
#include "drivers/simulated/shaker_plant.hpp"

namespace shaker {

namespace {

OpenRig open_simulated(const std::filesystem::path& scene, double frequency, World::Pace pace) {
    OpenRig open;
    open.scene = scene.empty() ? paper_scene() : read_scene(scene);
    open.world = std::make_unique<World>(open.scene, pace);
    open.rig = open.world->rig();
    for (std::size_t k = 0; k < max_harmonics; ++k) {
        const auto [re, im] = ShakerPlant::response(open.scene, static_cast<double>(k + 1) * frequency);
        open.response[k] = {re, im};
    }
    return open;
}

}  // namespace

OpenRig open_rig(const std::string& name, const std::filesystem::path& scene, double frequency,
                 World::Pace pace) {
    if (name == "sim:") return open_simulated(scene, frequency, pace);
    throw InputError{"--rig \"" + name + "\": no such rig; there is \"sim:\" (the simulated bench)"};
}

}  // namespace shaker

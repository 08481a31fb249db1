#include "daemon/rigs.hpp"

#include <fstream>
#include <iterator>

#include "drivers/errors.hpp"
#include "drivers/hardware/hardware_rig.hpp"
#include "drivers/simulated/shaker_plant.hpp"

namespace shaker {

namespace {

std::function<std::complex<double>(double)> predicted_response(const Scene& sheet) {
    return [sheet](double frequency) {
        const auto [re, im] = ShakerPlant::response(sheet, frequency);
        return std::complex<double>{re, im};
    };
}

OpenRig open_simulated(const std::filesystem::path& scene, World::Pace pace) {
    OpenRig open;
    open.scene = scene.empty() ? paper_scene() : read_scene(scene);
    open.world = std::make_unique<World>(open.scene, pace);
    open.rig = open.world->rig();
    open.shaker = open.scene.shaker;
    open.response = predicted_response(open.scene);
    return open;
}

OpenRig open_file(const std::filesystem::path& file) {
    if (!std::filesystem::is_regular_file(file))
        throw InputError{"--rig \"" + file.string() +
                         "\": no such file; a rig file (TOML) was expected, or sim: for the simulated bench"};
    OpenRig open;
    std::ifstream in{file};
    open.rig_text.assign(std::istreambuf_iterator<char>{in}, {});
    SettingsTable root = SettingsTable::from_file(file);
    Scene sheet = paper_scene();
    sheet.shaker = open.shaker = read_shaker(root.table("shaker"));
    if (root.tables("camera").empty())
        root.fail("camera", "at least one [[camera]] that sees the base was expected");
    for (const char* device : {"dac", "accelerometer"})
        if (!root.has(device)) root.fail(device, std::string{"a table ["} + device + "] was expected");
    HardwareRig bench = open_hardware_rig(root);
    open.rig = std::move(bench.rig);
    open.rig.name = file.string();
    open.granted = std::move(bench.granted);
    open.response = predicted_response(sheet);
    return open;
}

}  // namespace

OpenRig open_rig(const std::string& name, const std::filesystem::path& scene, World::Pace pace) {
    if (name == "sim:") return open_simulated(scene, pace);
    if (!scene.empty())
        throw InputError{"--scene \"" + scene.string() +
                         "\": only the simulated bench (--rig sim:) has a scene"};
    return open_file(name);
}

}  // namespace shaker

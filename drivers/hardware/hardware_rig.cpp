#include "drivers/hardware/hardware_rig.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <optional>
#include <set>
#include <utility>

#include "drivers/view_settings.hpp"

namespace shaker::hardware {

namespace {

struct ReadCamera {
    View view;
    OpenCamera open;
    DeviceAdvice advice;
};

ReadCamera read_camera(SettingsTable& table, std::set<std::string>& names,
                       std::span<const CameraKind> kinds) {
    View view = read_view(table, names);
    const CameraKind& kind = read_kind(table, kinds, false);
    OpenCamera open = kind.read(table, view);
    ReadCamera camera{.view = std::move(view), .open = std::move(open), .advice = kind.advice};
    camera.view.trigger_delay_s = table.number("trigger_delay_s", {0, 1}, 0);
    camera.view.arrival_delay_s = table.number("arrival_delay_s", {0, 10}, 0);
    table.text("calibration", "");  // the caller's
    table.finish();
    return camera;
}

void add_notes(std::vector<std::string>& all, const std::string& device,
               const std::vector<std::string>& lines) {
    for (const std::string& line : lines) all.push_back(fmt::format("{}: {}", device, line));
}

std::optional<gpio::AbortSettings> read_contact(SettingsTable& root) {
    if (!root.has("abort")) return std::nullopt;
    SettingsTable table = root.table("abort");
    const gpio::AbortSettings contact = gpio::read_abort(table);
    table.finish();
    return contact;
}

// Each card once.
template <class Kind>
void add_mixer(const Kind& kind, SettingsTable& table, std::vector<MixerDevice>& mixers) {
    if (kind.mixer == nullptr) return;
    if (auto mixer = kind.mixer(table))
        if (std::ranges::find(mixers, mixer->card, &MixerDevice::card) == mixers.end())
            mixers.push_back(std::move(*mixer));
}

}  // namespace

std::vector<ListedKind> list_devices(const Search& search, const Kinds& kinds) {
    std::vector<ListedKind> all;
    const auto add = [&](const auto& table) {
        for (const auto& kind : table) all.push_back({kind.heading, kind.key, kind.list(search)});
    };
    add(kinds.dacs);
    add(kinds.accelerometers);
    add(kinds.cameras);
    return all;
}

HardwareRig open_hardware_rig(SettingsTable& root, const Kinds& kinds) {
    SettingsTable dac_table = root.table("dac");
    const DacKind& dac_kind = read_kind(dac_table, kinds.dacs, true);
    const OpenDac open_dac = dac_kind.read(dac_table);
    std::vector<MixerDevice> mixers;
    add_mixer(dac_kind, dac_table, mixers);
    dac_table.finish();
    SettingsTable accelerometer_table = root.table("accelerometer");
    const AccelerometerKind& accelerometer_kind = read_kind(accelerometer_table, kinds.accelerometers, true);
    const OpenAccelerometer open_accelerometer = accelerometer_kind.read(accelerometer_table);
    add_mixer(accelerometer_kind, accelerometer_table, mixers);
    for (const char* key : {"calibration", "response"}) accelerometer_table.text(key, "");  // the caller's
    accelerometer_table.finish();
    std::set<std::string> names;
    std::vector<ReadCamera> cameras;
    for (SettingsTable& table : root.tables("camera"))
        cameras.push_back(read_camera(table, names, kinds.cameras));
    const std::optional<gpio::AbortSettings> contact = read_contact(root);
    root.finish();

    HardwareRig bench;
    bench.rig.advice = {.dac = dac_kind.advice, .accelerometer = accelerometer_kind.advice, .cameras = {}};
    for (ReadCamera& camera : cameras) {
        Notes notes;
        const std::string name = "camera \"" + camera.view.camera + "\"";
        bench.rig.cameras.push_back(camera.open(std::move(camera.view), notes));
        bench.rig.advice.cameras.push_back(camera.advice);
        add_notes(bench.granted, name, notes);
    }
    Notes notes;
    bench.rig.accelerometer = open_accelerometer(notes);
    add_notes(bench.granted, bench.rig.accelerometer->info().name, notes);
    bench.rig.dac = open_dac(bench.granted);
    bench.rig.mixers = std::move(mixers);
    if (contact) {
        bench.rig.abort_input =
            std::make_unique<gpio::ContactInput>(kinds.open_line(contact->at, contact->pull), *contact);
        bench.granted.push_back(fmt::format("abort input: {}, closed is {}", contact->at.text(),
                                            contact->closed_high ? "high" : "low"));
    }
    return bench;
}

}  // namespace shaker::hardware

#include "drivers/hardware/hardware_rig.hpp"

#include <spdlog/fmt/fmt.h>

#include <optional>
#include <set>
#include <utility>

#include "drivers/hardware/gpio/contact_input.hpp"
#include "drivers/hardware/gpio/pulsed_output.hpp"
#include "drivers/ticks.hpp"
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
    table.finish();
    return camera;
}

void add_notes(std::vector<std::string>& all, const std::string& device,
               const std::vector<std::string>& lines) {
    for (const std::string& line : lines) all.push_back(fmt::format("{}: {}", device, line));
}

/// The optional tables of GPIO lines.
struct SwitchTables {
    std::optional<SettingsTable> enable_table, abort_table;
    std::optional<gpio::EnableSettings> enable;
    std::optional<gpio::AbortSettings> abort;
};

SwitchTables read_switches(SettingsTable& root) {
    SwitchTables read;
    if (root.has("enable")) {
        read.enable_table = root.table("enable");
        read.enable = gpio::read_enable(*read.enable_table);
        read.enable_table->finish();
    }
    if (root.has("abort")) {
        read.abort_table = root.table("abort");
        read.abort = gpio::read_abort(*read.abort_table);
        read.abort_table->finish();
    }
    if (read.enable && read.abort && read.enable->at == read.abort->at)
        read.abort_table->fail("line",
                               read.abort->at.text() + " is the line of [enable]; choose another one");
    return read;
}

// The line must toggle for as long as the DAC plays after the last block.
void open_switches(const SwitchTables& read, const gpio::Lines& lines, HardwareRig& bench) {
    const DacInfo dac = bench.rig.dac->info();
    const double plays_s = duration_s(dac.queue_frames + dac.ramp_frames, dac.rate_hz);
    if (read.enable && read.enable->hold_s < plays_s)
        read.enable_table->fail(
            "hold_s",
            fmt::format("{} is shorter than the buffer of the DAC, whose ramp would be cut off; must be "
                        "{:.3f} to 1",
                        read.enable->hold_s, plays_s));
    if (read.enable) {
        bench.rig.enable = std::make_unique<gpio::PulsedOutput>(lines.output(read.enable->at), *read.enable);
        bench.granted.push_back(
            fmt::format("enable output: {} toggles at {} Hz while the bench drives, and stops at most {:.0f} "
                        "ms after the "
                        "last block",
                        read.enable->at.text(), read.enable->toggle_hz,
                        1e3 * (read.enable->hold_s + 0.5 / read.enable->toggle_hz)));
    }
    if (read.abort) {
        bench.rig.abort_input =
            std::make_unique<gpio::ContactInput>(lines.input(read.abort->at, read.abort->pull), *read.abort);
        bench.granted.push_back(fmt::format("abort input: {}, closed is {}", read.abort->at.text(),
                                            read.abort->closed_high ? "high" : "low"));
    }
}

}  // namespace

HardwareRig open_hardware_rig(SettingsTable& root, const Kinds& kinds) {
    SettingsTable dac_table = root.table("dac");
    const DacKind& dac_kind = read_kind(dac_table, kinds.dacs, true);
    const OpenDac open_dac = dac_kind.read(dac_table);
    dac_table.finish();
    SettingsTable accelerometer_table = root.table("accelerometer");
    const AccelerometerKind& accelerometer_kind = read_kind(accelerometer_table, kinds.accelerometers, true);
    const OpenAccelerometer open_accelerometer = accelerometer_kind.read(accelerometer_table);
    accelerometer_table.finish();
    std::set<std::string> names;
    std::vector<ReadCamera> cameras;
    for (SettingsTable& table : root.tables("camera"))
        cameras.push_back(read_camera(table, names, kinds.cameras));
    const SwitchTables switches = read_switches(root);
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
    open_switches(switches, kinds.lines, bench);
    return bench;
}

}  // namespace shaker::hardware

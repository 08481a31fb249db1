#include "drivers/hardware/hardware_rig.hpp"

#include <set>
#include <utility>
#include <variant>

#include "drivers/hardware/alsa_dac.hpp"
#include "drivers/hardware/genicam_camera.hpp"
#include "drivers/hardware/iio_accelerometer.hpp"
#include "drivers/hardware/video_camera.hpp"
#include "drivers/view_settings.hpp"

namespace shaker {

namespace {

struct CameraSettings {
    View view;
    std::variant<GenicamSettings, VideoSettings> driver;
};

CameraSettings read_camera(SettingsTable& table, std::set<std::string>& names) {
    CameraSettings camera{.view = read_view(table, names), .driver = {}};
    if (table.choice("driver", {"genicam", "video"}) == 0) {
        GenicamSettings genicam = read_genicam_settings(table);
        camera.view.dac_triggered = genicam.trigger == CameraTrigger::dac;
        camera.driver = std::move(genicam);
    } else {
        camera.driver = read_video_settings(table);
    }
    camera.view.trigger_delay_s = table.number("trigger_delay_s", {0, 1}, 0);
    camera.view.arrival_delay_s = table.number("arrival_delay_s", {0, 10}, 0);
    table.finish();
    return camera;
}

void tell(std::vector<std::string>& all, const std::string& device, const std::vector<std::string>& lines) {
    for (const std::string& line : lines) all.push_back(device + ": " + line);
}

}  // namespace

HardwareRig open_hardware_rig(SettingsTable& root) {
    SettingsTable dac_table = root.table("dac");
    const AlsaSettings dac_settings = read_alsa_settings(dac_table);
    dac_table.finish();
    SettingsTable accelerometer_table = root.table("accelerometer");
    const IioSettings accelerometer_settings = read_iio_settings(accelerometer_table);
    accelerometer_table.finish();
    std::set<std::string> names;
    std::vector<CameraSettings> cameras;
    for (SettingsTable& table : root.tables("camera")) cameras.push_back(read_camera(table, names));
    root.finish();

    HardwareRig bench;
    for (CameraSettings& camera : cameras) {
        std::vector<std::string> lines;
        const std::string name = "camera \"" + camera.view.camera + "\"";
        bench.rig.cameras.push_back(
            std::holds_alternative<GenicamSettings>(camera.driver)
                ? open_genicam_camera(std::get<GenicamSettings>(camera.driver), std::move(camera.view),
                                      &lines)
                : open_video_camera(std::get<VideoSettings>(camera.driver), std::move(camera.view), &lines));
        tell(bench.granted, name, lines);
    }
    std::vector<std::string> notes;
    bench.rig.accelerometer = open_iio_accelerometer(accelerometer_settings, &notes);
    tell(bench.granted, bench.rig.accelerometer->info().name, notes);
    auto dac = std::make_unique<AlsaDac>(dac_settings);
    bench.granted.push_back(dac->granted().text());
    bench.rig.dac = std::move(dac);
    return bench;
}

}  // namespace shaker

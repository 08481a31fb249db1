#include "drivers/hardware/genicam/kind.hpp"

#include <spdlog/fmt/fmt.h>
#include <spdlog/fmt/ranges.h>

#include <nlohmann/json.hpp>

#include "drivers/hardware/genicam/devices.hpp"
#include "drivers/hardware/genicam/genicam_camera.hpp"

namespace shaker::genicam {

namespace {

using Json = nlohmann::ordered_json;

Json json_of(const GenicamDevice& d) {
    Json j{{"id", d.id},       {"address", d.address}, {"vendor", d.vendor},
           {"model", d.model}, {"serial", d.serial},   {"protocol", d.protocol}};
    if (!d.trouble.empty()) {
        j["error"] = d.trouble;
        return j;
    }
    j["sensor_px"] = {d.sensor_width, d.sensor_height};
    j["pixel_formats"] = d.pixel_formats;
    j["rate_hz"] = {d.rate_hz.min, d.rate_hz.max};
    j["trigger_sources"] = d.trigger_sources;
    return j;
}

std::string text_of(const GenicamDevice& d) {
    std::string s = fmt::format("  driver = \"genicam\"  id = \"{}\"\n      {} {} at {}, {}\n", d.id,
                                d.vendor, d.model, d.address, d.protocol);
    if (!d.trouble.empty()) return s + "      " + d.trouble + "\n";
    return s + fmt::format("      {} x {} px, {}; {} Hz; trigger {}\n", d.sensor_width, d.sensor_height,
                           fmt::join(d.pixel_formats, ", "), to_text(d.rate_hz),
                           fmt::join(d.trigger_sources, ", "));
}

}  // namespace

hardware::OpenCamera read_kind(SettingsTable& table, View& view) {
    GenicamSettings settings = read_genicam_settings(table);
    view.dac_triggered = settings.trigger == CameraTrigger::dac;
    return [settings = std::move(settings)](View sees, hardware::Notes& notes) {
        return open_genicam_camera(settings, std::move(sees), &notes);
    };
}

std::vector<hardware::ListedDevice> list_kind(const hardware::Search& /*search*/) {
    std::vector<hardware::ListedDevice> all;
    for (const GenicamDevice& device : list_genicam_devices())
        all.push_back({text_of(device), json_of(device).dump()});
    return all;
}

}  // namespace shaker::genicam

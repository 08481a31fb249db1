#include "drivers/hardware/genicam/kind.hpp"

#include <arv.h>
#include <spdlog/fmt/fmt.h>
#include <spdlog/fmt/ranges.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "drivers/hardware/genicam/genicam_camera.hpp"
#include "drivers/hardware/genicam/setup.hpp"

namespace shaker::genicam {

namespace {

std::string text(const char* words) { return words != nullptr ? words : ""; }

std::vector<std::string> texts(const char** words, guint n) {
    std::vector<std::string> result;
    for (guint i = 0; words != nullptr && i < n; ++i) result.emplace_back(words[i]);
    g_free(static_cast<gpointer>(words));
    return result;
}

void ask(GenicamDevice& device) {
    GError* error = nullptr;
    const CameraHandle camera{arv_camera_new(device.id.c_str(), &error)};
    if (camera != nullptr && error == nullptr)
        arv_camera_get_sensor_size(camera.get(), &device.sensor_width, &device.sensor_height, &error);
    if (camera != nullptr && error == nullptr)
        arv_camera_get_frame_rate_bounds(camera.get(), &device.rate_hz.min, &device.rate_hz.max, &error);
    if (camera != nullptr && error == nullptr) {
        guint n = 0;
        const char** names = arv_camera_dup_available_pixel_formats_as_strings(camera.get(), &n, &error);
        device.pixel_formats = texts(names, n);
    }
    if (camera != nullptr && error == nullptr) {
        guint n = 0;
        const char** names = arv_camera_dup_available_trigger_sources(camera.get(), &n, &error);
        device.trigger_sources = texts(names, n);
    }
    if (error != nullptr) device.trouble = error->message;
    if (camera == nullptr && error == nullptr) device.trouble = "no answer";
    g_clear_error(&error);
}

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

std::vector<GenicamDevice> list_genicam_devices() {
    log_lines_of_glib();
    arv_update_device_list();
    std::vector<GenicamDevice> devices;
    for (unsigned i = 0; i < arv_get_n_devices(); ++i) {
        GenicamDevice device;
        device.id = text(arv_get_device_id(i));
        device.address = text(arv_get_device_address(i));
        device.vendor = text(arv_get_device_vendor(i));
        device.model = text(arv_get_device_model(i));
        device.serial = text(arv_get_device_serial_nbr(i));
        device.protocol = text(arv_get_device_protocol(i));
        devices.push_back(std::move(device));
    }
    for (GenicamDevice& device : devices) ask(device);
    return devices;
}

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

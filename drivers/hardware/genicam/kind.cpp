#include "drivers/hardware/genicam/kind.hpp"

#include <arv.h>
#include <spdlog/fmt/fmt.h>
#include <spdlog/fmt/ranges.h>

#include <nlohmann/json.hpp>

#include "drivers/hardware/genicam/genicam_camera.hpp"
#include "drivers/hardware/genicam/setup.hpp"
#include "drivers/quantity.hpp"

namespace shaker::genicam {

namespace {

using Json = nlohmann::ordered_json;

std::string text(const char* words) { return words != nullptr ? words : ""; }

/// Adds what the camera itself says, or why it cannot be asked.
void ask(Json& device) {
    GError* error = nullptr;
    const CameraHandle camera{arv_camera_new(device["id"].get<std::string>().c_str(), &error)};
    const auto answers = [&] { return camera != nullptr && error == nullptr; };
    const auto names = [&](auto* get) {
        std::vector<std::string> result;
        guint n = 0;
        const char** const words = answers() ? get(camera.get(), &n, &error) : nullptr;
        for (guint i = 0; words != nullptr && i < n; ++i) result.emplace_back(words[i]);
        g_free(static_cast<gpointer>(words));
        return result;
    };
    int width = 0, height = 0;
    if (answers()) arv_camera_get_sensor_size(camera.get(), &width, &height, &error);
    Range rate_hz{0, 0};
    if (answers()) arv_camera_get_frame_rate_bounds(camera.get(), &rate_hz.min, &rate_hz.max, &error);
    const auto pixel_formats = names(arv_camera_dup_available_pixel_formats_as_strings);
    const auto trigger_sources = names(arv_camera_dup_available_trigger_sources);
    if (!answers()) {
        device["error"] = error != nullptr ? error->message : "no answer";
        return g_clear_error(&error);
    }
    device["sensor_px"] = {width, height};
    device["pixel_formats"] = pixel_formats;
    device["rate_hz"] = {rate_hz.min, rate_hz.max};
    device["trigger_sources"] = trigger_sources;
}

std::string text_of(const Json& d) {
    const auto word = [&d](const char* key) { return d[key].get<std::string>(); };
    std::string s = fmt::format("  driver = \"genicam\"  id = \"{}\"\n      {} {} at {}, {}\n", word("id"),
                                word("vendor"), word("model"), word("address"), word("protocol"));
    if (d.contains("error")) return s + "      " + word("error") + "\n";
    const auto words = [&d](const char* key) { return d[key].get<std::vector<std::string>>(); };
    return s + fmt::format("      {} x {} px, {}; {} Hz; trigger {}\n", d["sensor_px"][0].get<int>(),
                           d["sensor_px"][1].get<int>(), fmt::join(words("pixel_formats"), ", "),
                           to_text(Range{d["rate_hz"][0], d["rate_hz"][1]}),
                           fmt::join(words("trigger_sources"), ", "));
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
    log_lines_of_glib();
    arv_update_device_list();
    std::vector<Json> devices;
    for (unsigned i = 0; i < arv_get_n_devices(); ++i)
        devices.push_back({{"id", text(arv_get_device_id(i))},  // stable: vendor, model, serial number
                           {"address", text(arv_get_device_address(i))},  // may change
                           {"vendor", text(arv_get_device_vendor(i))},
                           {"model", text(arv_get_device_model(i))},
                           {"serial", text(arv_get_device_serial_nbr(i))},
                           {"protocol", text(arv_get_device_protocol(i))}});
    std::vector<hardware::ListedDevice> all;
    for (Json& device : devices) {
        ask(device);
        all.push_back({text_of(device), device.dump()});
    }
    return all;
}

}  // namespace shaker::genicam

#include "drivers/hardware/video/kind.hpp"

#include <spdlog/fmt/fmt.h>
#include <spdlog/fmt/ranges.h>

#include <nlohmann/json.hpp>

#include "drivers/hardware/video/devices.hpp"
#include "drivers/hardware/video/video_camera.hpp"

namespace shaker::video {

namespace {

using Json = nlohmann::ordered_json;

Json json_of(const VideoDevice& d) {
    Json j{{"path", d.path.string()},
           {"stable_id", d.stable_id.string()},
           {"name", d.name},
           {"driver", d.driver},
           {"pictures", d.pictures}};
    if (!d.trouble.empty()) j["error"] = d.trouble;
    return j;
}

std::string text_of(const VideoDevice& d) {
    const std::string id = (d.stable_id.empty() ? d.path : d.stable_id).string();
    std::string s =
        fmt::format("  driver = \"video\"  device = \"{}\"\n      {} ({})\n", id, d.name, d.driver);
    for (const std::string& picture : d.pictures) s += "      " + picture + "\n";
    return d.trouble.empty() ? s : s + "      " + d.trouble + "\n";
}

}  // namespace

hardware::OpenCamera read_kind(SettingsTable& table, View& /*view*/) {
    return [settings = read_video_settings(table)](View sees, hardware::Notes& notes) {
        return open_video_camera(settings, std::move(sees), &notes);
    };
}

std::vector<hardware::ListedDevice> list_kind(const hardware::Search& /*search*/) {
    std::vector<hardware::ListedDevice> all;
    for (const VideoDevice& device : list_video_devices())
        all.push_back({text_of(device), json_of(device).dump()});
    return all;
}

}  // namespace shaker::video

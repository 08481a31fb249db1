#include "drivers/hardware/video/kind.hpp"

#include <fcntl.h>
#include <linux/videodev2.h>
#include <spdlog/fmt/fmt.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <nlohmann/json.hpp>

#include "drivers/descriptor.hpp"
#include "drivers/hardware/video/video_camera.hpp"
#include "drivers/quantity.hpp"

namespace shaker::video {

namespace {

using Json = nlohmann::ordered_json;

std::string four_letters(std::uint32_t code) {
    std::string text;
    for (int i = 0; i < 4; ++i) text += static_cast<char>(code >> (8 * i) & 0x7f);
    return text.substr(0, text.find_last_not_of(' ') + 1);
}

template <std::size_t n>
std::string words(const std::uint8_t (&field)[n]) {
    const auto* const begin = reinterpret_cast<const char*>(field);
    return {begin, strnlen(begin, n)};
}

/// The highest rate of one size, Hz; 0 when the driver does not report it.
double highest_rate(int fd, std::uint32_t format, std::uint32_t width, std::uint32_t height) {
    double best = 0;
    v4l2_frmivalenum interval{};
    interval.pixel_format = format;
    interval.width = width;
    interval.height = height;
    for (; ioctl(fd, VIDIOC_ENUM_FRAMEINTERVALS, &interval) == 0; ++interval.index) {
        const v4l2_fract& s =
            interval.type == V4L2_FRMIVAL_TYPE_DISCRETE ? interval.discrete : interval.stepwise.min;
        if (s.numerator > 0) best = std::max(best, static_cast<double>(s.denominator) / s.numerator);
        if (interval.type != V4L2_FRMIVAL_TYPE_DISCRETE) break;
    }
    return best;
}

/// Adds lines such as "GREY 320x180 up to 60 Hz", one per size.
void list_sizes(int fd, std::uint32_t format, Json& lines) {
    v4l2_frmsizeenum size{};
    size.pixel_format = format;
    for (; ioctl(fd, VIDIOC_ENUM_FRAMESIZES, &size) == 0; ++size.index) {
        const bool discrete = size.type == V4L2_FRMSIZE_TYPE_DISCRETE;
        const std::uint32_t width = discrete ? size.discrete.width : size.stepwise.max_width;
        const std::uint32_t height = discrete ? size.discrete.height : size.stepwise.max_height;
        const double rate = highest_rate(fd, format, width, height);
        lines.push_back(four_letters(format) + (discrete ? " " : " up to ") + std::to_string(width) + "x" +
                        std::to_string(height) + (rate > 0 ? " up to " + to_text(rate) + " Hz" : ""));
        if (!discrete) break;
    }
}

/// The link in /dev/v4l/by-id, which stays the same; empty without one.
std::filesystem::path stable_link(const std::filesystem::path& folder, const std::filesystem::path& path) {
    std::error_code ignored;
    for (const auto& link : std::filesystem::directory_iterator{folder / "v4l" / "by-id", ignored})
        if (std::filesystem::equivalent(link.path(), path, ignored)) return link.path();
    return {};
}

/// Queries a device; null when it does not capture pictures.
Json ask(const std::filesystem::path& folder, const std::filesystem::path& path) {
    Json device{{"path", path.string()},
                {"stable_id", stable_link(folder, path).string()},
                {"name", ""},
                {"driver", ""},
                {"pictures", Json::array()}};
    const Descriptor fd{open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC)};
    v4l2_capability capability{};
    if (fd < 0 || ioctl(fd, VIDIOC_QUERYCAP, &capability) != 0) {
        device["error"] = std::strerror(errno);
        return device;
    }
    if ((capability.device_caps & V4L2_CAP_VIDEO_CAPTURE) == 0) return {};
    device["name"] = words(capability.card);
    device["driver"] = words(capability.driver);
    v4l2_fmtdesc format{};
    format.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    for (; ioctl(fd, VIDIOC_ENUM_FMT, &format) == 0; ++format.index)
        list_sizes(fd, format.pixelformat, device["pictures"]);
    return device;
}

std::string text_of(const Json& d) {
    const std::string id = d[d["stable_id"] == "" ? "path" : "stable_id"], name = d["name"],
                      driver = d["driver"];
    std::string s = fmt::format("  driver = \"video\"  device = \"{}\"\n      {} ({})\n", id, name, driver);
    for (const std::string picture : d["pictures"]) s += "      " + picture + "\n";
    return d.contains("error") ? s + "      " + d["error"].get<std::string>() + "\n" : s;
}

}  // namespace

std::vector<hardware::ListedDevice> list_video_devices(const std::filesystem::path& folder) {
    std::vector<std::filesystem::path> paths;
    std::error_code ignored;
    for (const auto& entry : std::filesystem::directory_iterator{folder, ignored})
        if (entry.path().filename().string().starts_with("video")) paths.push_back(entry.path());
    std::ranges::sort(paths);
    std::vector<hardware::ListedDevice> all;
    for (const std::filesystem::path& path : paths)
        if (const Json device = ask(folder, path); !device.is_null())
            all.push_back({text_of(device), device.dump()});
    return all;
}

hardware::OpenCamera read_kind(SettingsTable& table, View& /*view*/) {
    return [settings = read_video_settings(table)](View sees, hardware::Notes& notes) {
        return open_video_camera(settings, std::move(sees), &notes);
    };
}

std::vector<hardware::ListedDevice> list_kind(const hardware::Search& /*search*/) {
    return list_video_devices("/dev");
}

}  // namespace shaker::video

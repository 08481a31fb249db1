#include "drivers/hardware/video/kind.hpp"

#include <fcntl.h>
#include <linux/videodev2.h>
#include <spdlog/fmt/fmt.h>
#include <spdlog/fmt/ranges.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <nlohmann/json.hpp>
#include <optional>

#include "drivers/descriptor.hpp"
#include "drivers/hardware/video/video_camera.hpp"
#include "drivers/quantity.hpp"

namespace shaker::video {

namespace {

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

void list_sizes(int fd, std::uint32_t format, std::vector<std::string>& lines) {
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

/// Queries a device; empty when it does not capture pictures.
std::optional<VideoDevice> ask(const std::filesystem::path& path) {
    VideoDevice device;
    device.path = path;
    const Descriptor fd{open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC)};
    v4l2_capability capability{};
    if (fd < 0 || ioctl(fd, VIDIOC_QUERYCAP, &capability) != 0) {
        device.trouble = std::strerror(errno);
        return device;
    }
    device.name = words(capability.card);
    device.driver = words(capability.driver);
    const bool captures = (capability.device_caps & V4L2_CAP_VIDEO_CAPTURE) != 0;
    v4l2_fmtdesc format{};
    format.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    for (; captures && ioctl(fd, VIDIOC_ENUM_FMT, &format) == 0; ++format.index)
        list_sizes(fd, format.pixelformat, device.pictures);
    if (!captures) return {};
    return device;
}

std::filesystem::path stable_link(const std::filesystem::path& folder, const std::filesystem::path& path) {
    std::error_code ignored;
    for (const auto& link : std::filesystem::directory_iterator{folder / "v4l" / "by-id", ignored})
        if (std::filesystem::equivalent(link.path(), path, ignored)) return link.path();
    return {};
}

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

std::vector<VideoDevice> list_video_devices(const std::filesystem::path& folder) {
    std::vector<VideoDevice> devices;
    std::error_code ignored;
    for (const auto& entry : std::filesystem::directory_iterator{folder, ignored}) {
        if (!entry.path().filename().string().starts_with("video")) continue;
        if (auto device = ask(entry.path())) {
            device->stable_id = stable_link(folder, entry.path());
            devices.push_back(std::move(*device));
        }
    }
    std::ranges::sort(devices, {}, &VideoDevice::path);
    return devices;
}

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

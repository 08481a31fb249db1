#pragma once
// The row of this folder in a table of kinds, and the devices that are connected.
#include <filesystem>
#include <string>
#include <vector>

#include "drivers/hardware/kind/device_kind.hpp"

namespace shaker::video {

struct VideoDevice {
    std::filesystem::path path;       // "/dev/video0"; may change
    std::filesystem::path stable_id;  // link to it in /dev/v4l/by-id, or empty
    std::string name;                 // from the driver
    std::string driver;
    std::vector<std::string> pictures;  // "GREY 320x180 up to 60 Hz", one line per size
    std::string trouble;                // why it could not be queried; empty: it could
};

/// Every /dev/video* that captures pictures or cannot be queried. `folder` is /dev except in tests.
std::vector<VideoDevice> list_video_devices(const std::filesystem::path& folder = "/dev");

hardware::OpenCamera read_kind(SettingsTable& table, View& view);
std::vector<hardware::ListedDevice> list_kind(const hardware::Search& search);

inline constexpr hardware::CameraKind video_kind{
    .name = "video",
    .heading = "[[camera]] video",
    .key = "video_cameras",
    .read = read_kind,
    .list = list_kind,
    .search = {},
    .advice = {.silent = "is another program using it, and is it on a fast USB port?",
               .rate_off = "does poor light lower its frame rate?"}};

}  // namespace shaker::video

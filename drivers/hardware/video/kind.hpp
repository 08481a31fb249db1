#pragma once
// The row of this folder in a table of kinds, and the devices that are connected.
#include <filesystem>
#include <vector>

#include "drivers/hardware/kind/device_kind.hpp"

namespace shaker::video {

/// Every video* in the folder that captures pictures or cannot be queried.
std::vector<hardware::ListedDevice> list_video_devices(const std::filesystem::path& folder);

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

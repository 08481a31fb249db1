#pragma once
// Lists the V4L2 cameras.
#include <filesystem>
#include <string>
#include <vector>

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

}  // namespace shaker::video

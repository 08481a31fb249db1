#pragma once
// Which V4L2 cameras there are, for lists.
#include <filesystem>
#include <string>
#include <vector>

namespace shaker {

struct VideoDevice {
    std::filesystem::path path;       // "/dev/video0"; may change
    std::filesystem::path stable_id;  // a link below /dev/v4l/by-id to it, or empty
    std::string name;                 // the driver's own
    std::string driver;
    std::vector<std::string> pictures;  // "GREY 320x180 up to 60 Hz", one line for each size
    std::string trouble;                // why it could not be asked; empty when it could
};

/// Every /dev/video* that captures pictures, or cannot be asked. `folder` is /dev except in tests.
std::vector<VideoDevice> list_video_devices(const std::filesystem::path& folder = "/dev");

}  // namespace shaker

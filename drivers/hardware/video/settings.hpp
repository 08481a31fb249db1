#pragma once
// Settings of a V4L2 camera, or of a movie that replaces one, in a rig file.
#include <filesystem>

#include "drivers/settings_table.hpp"

namespace shaker::video {

struct VideoSettings {
    std::filesystem::path device;  // "/dev/video0", or better a link in /dev/v4l/by-id; or empty
    std::filesystem::path file;    // a movie; or empty
    int width = 0;                 // px, picture of the device; 0: unchanged
    int height = 0;
    double frame_rate_hz = 0;  // 0: that of the device or file
    double exposure_s = 0;     // s, of the device; 0: unchanged
    bool paced = true;         // true: the movie is played at its rate; false: as fast as possible
};

/// Reads and checks these keys: device or file (exactly one), width_px and height_px, frame_rate_hz,
/// exposure_s, pace ("rate" or "fast"). Throws InputError.
VideoSettings read_video_settings(SettingsTable& table);

}  // namespace shaker::video

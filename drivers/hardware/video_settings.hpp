#pragma once
// What a rig file asks of a V4L2 camera, or of a movie that stands in for one.
#include <filesystem>

#include "drivers/settings_table.hpp"

namespace shaker {

struct VideoSettings {
    std::filesystem::path device;  // "/dev/video0", better a link below /dev/v4l/by-id; or empty
    std::filesystem::path file;    // a movie; or empty
    int width = 0;                 // of the device's picture, pixels; 0: as it is
    int height = 0;
    double frame_rate_hz = 0;  // 0: as the device or the file has it
    double exposure_s = 0;     // of the device; 0: as it is
    bool paced = true;         // a movie is played at its rate; false: as fast as it is read
};

/// Reads and checks these keys: device or file (exactly one), width_px and height_px, frame_rate_hz,
/// exposure_s, pace ("rate" or "fast"). Throws InputError.
VideoSettings read_video_settings(SettingsTable& table);

}  // namespace shaker

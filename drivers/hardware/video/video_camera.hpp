#pragma once
// V4L2 cameras, and movies that replace one, as a Camera (through OpenCV).
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "drivers/devices.hpp"
#include "drivers/settings_table.hpp"

namespace shaker::video {

/// Settings of a V4L2 camera, or of a movie that replaces one, in a rig file.
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

/// Opens the device or movie. `view`: geometry and targets; its frame rate is replaced by the granted one.
/// Colour is converted to grey; 16-bit grey is kept. `granted`, if given, receives one line per requested
/// setting.
///
/// A V4L2 device stamps each picture at the end of its transfer with the host's monotonic clock: this is
/// Frame::stamp and Frame::arrived. Drivers with another clock provide the arrival only. Lost pictures are
/// detected as steps of the stamps and counted. read() throws DeviceError when a device sends nothing for 2 s
/// or is unplugged.
///
/// The stamps of a movie are its own time. A movie ends; a device does not.
///
/// Throws DeviceError when it cannot be opened or does not grant the picture size.
std::unique_ptr<Camera> open_video_camera(const VideoSettings& settings, View view,
                                          std::vector<std::string>* granted = nullptr);

}  // namespace shaker::video

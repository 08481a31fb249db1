#pragma once
// V4L2 cameras, and movies that replace one, as a Camera (through OpenCV).
#include <memory>
#include <string>
#include <vector>

#include "drivers/devices.hpp"
#include "drivers/hardware/video/settings.hpp"

namespace shaker::video {

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

#pragma once
// V4L2 cameras, and movies that stand in for one, as a Camera (through OpenCV).
#include <memory>
#include <string>
#include <vector>

#include "drivers/devices.hpp"
#include "drivers/hardware/video_settings.hpp"

namespace shaker {

/// Opens the device or the movie. `view` tells what it sees; its frame rate is set to what was granted.
/// Colour becomes grey; 16-bit grey stays. `granted`, when given, gets one line for each thing asked for.
///
/// A V4L2 device stamps each picture at the end of its transfer on the host's monotonic clock: that is
/// Frame::stamp and Frame::arrived; drivers that use another clock give the arrival only. Pictures that were
/// lost show as steps of the stamps and are counted. A device that sends nothing for 2 s throws DeviceError,
/// and so does one that is unplugged.
///
/// A movie's stamps are its own time. It ends; a device does not.
///
/// Throws DeviceError when it cannot be opened or does not grant the picture's size.
std::unique_ptr<Camera> open_video_camera(const VideoSettings& settings, View view,
                                          std::vector<std::string>* granted = nullptr);

}  // namespace shaker

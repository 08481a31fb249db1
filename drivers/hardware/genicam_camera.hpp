#pragma once
// A GenICam camera (GigE Vision, USB3 Vision; through Aravis) as a Camera.
#include <memory>
#include <string>
#include <vector>

#include "drivers/devices.hpp"
#include "drivers/hardware/genicam_settings.hpp"

namespace shaker {

/// Opens the camera and lets it run. `view` tells what it sees; its frame rate and exposure are set to what
/// was granted. Pictures of more than 8 bits come as 16-bit codes, not scaled: full scale is that of the
/// format. `granted`, when given, gets one line for each thing asked for.
///
/// Ticks count exposures: those that were lost on the way (frame ids) or left out by the camera (time stamps)
/// are counted as lost, and the frame after them has Quality::gap. With a trigger from the DAC a silence of
/// more than 1 s (or 10 periods) is a pause of the trigger, not a loss. Frame::stamp is on the camera's own
/// clock; Frame::arrived is when the first packet was handled.
///
/// A camera that goes away (no answer, or no pictures for that long while it should send some) is looked for
/// and opened again, by a thread of its own; read() meanwhile returns null. Ticks then go on from the time
/// that passed. read() throws DeviceError when it was away for give_up_s.
///
/// Throws DeviceError when it cannot be opened or refuses a setting.
std::unique_ptr<Camera> open_genicam_camera(const GenicamSettings& settings, View view,
                                            std::vector<std::string>* granted = nullptr);

}  // namespace shaker

#pragma once
// A GenICam camera (GigE Vision, USB3 Vision; through Aravis) as a Camera.
#include <memory>
#include <string>
#include <vector>

#include "drivers/devices.hpp"
#include "drivers/hardware/genicam/settings.hpp"

namespace shaker::genicam {

/// Opens and starts the camera. `view`: geometry and targets; its frame rate and exposure are replaced by the
/// granted ones. Pictures of more than 8 bits are delivered as 16-bit codes without scaling: full scale is
/// that of the format. `granted`, if given, receives one line per requested setting.
///
/// Ticks count exposures. Exposures lost in transfer (frame ids) or left out by the camera (time stamps)
/// count as lost, and the next frame has Quality::gap. With a trigger from the DAC, a silence of more than 1
/// s (or 10 periods) is a pause of the trigger, not a loss. Frame::stamp is on the camera's clock;
/// Frame::arrived is the time of the first packet.
///
/// A camera that disappears (no answer, or no pictures for that long while it should send them) is searched
/// and opened again by a separate thread; read() returns null meanwhile. Ticks then continue from the elapsed
/// time. read() throws DeviceError after give_up_s.
///
/// Throws DeviceError when the camera cannot be opened or refuses a setting.
std::unique_ptr<Camera> open_genicam_camera(const GenicamSettings& settings, View view,
                                            std::vector<std::string>* granted = nullptr);

}  // namespace shaker::genicam

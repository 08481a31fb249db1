#pragma once
// One camera of a lab session: its pictures with the times of their exposures.
#include <memory>
#include <string>

#include "drivers/devices.hpp"
#include "drivers/replay/lab_session.hpp"

namespace shaker {

struct OpenCamera {
    std::unique_ptr<Camera> camera;  // holds one picture in memory beside those it has given away
    std::string note;                // what the user should know about the file; empty when there is nothing
};

/// Opens a camera's file and times. view().frame_rate_hz is the description's, else that of times (their
/// median step) or the file's own. Throws InputError naming the file: see open_lab_session.
OpenCamera open_media_camera(const LabCamera& description);

}  // namespace shaker

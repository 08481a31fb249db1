#pragma once
// One camera of a lab session: pictures with the times of their exposures.
#include <memory>
#include <string>

#include "drivers/devices.hpp"
#include "drivers/footage/lab_session.hpp"

namespace shaker::footage {

struct OpenCamera {
    std::unique_ptr<Camera> camera;  // keeps one picture in memory besides those it has returned
    std::string note;                // properties of the file that the user should know; may be empty
};

/// Opens a camera's file and times. view().frame_rate_hz: from the description, else from `times` (median
/// step), else from the file. Throws InputError with the file; see open_lab_session.
OpenCamera open_media_camera(const LabCamera& description);

}  // namespace shaker::footage

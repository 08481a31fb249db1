#pragma once
// The calibration file of a camera: TOML with a checksum, named by rig files and kept by recordings.
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "drivers/devices.hpp"

namespace shaker::calibration {

struct CameraCalibration {
    std::string date;            // ISO 8601
    std::string camera;          // its name in the rig file
    std::array<int, 2> size_px;  // of its pictures
    /// Of the reference plane; distance_mm 0: not determined, that of the rig file holds.
    double mm_per_px = 0, scale_error = 0, distance_mm = 0;
    std::array<double, 2> along{1, 0};
    std::array<double, 2> tilt_deg{};
    Lens lens{};                          // focal_px 0: none
    std::string how;                      // "board" or "length"
    double rms_px = 0;                    // of the corners about the fit
    int pictures = 0, corners = 0;        // used
    std::vector<std::string> findings{};  // one sentence each
};

/// The content of a file; its last line is the SHA-256 of the lines above.
std::string calibration_text(const CameraCalibration& calibration);

/// InputError names the file, and states when it was changed after it was written.
CameraCalibration parse_camera_calibration(const std::string& text, const std::string& file);

/// The view with scale, error, direction, tilt and lens of the file. InputError when the file was made of a
/// camera of another name, or its scale differs by more than 10 % from the view's: another lens, distance or
/// binning.
View calibrated(View view, const CameraCalibration& by, const std::string& text, const std::string& file);

/// The camera with a view by the file. Adds a sentence to `notes`: file, date and error of the scale.
/// InputError as from its parts.
std::unique_ptr<Camera> with_calibration(std::unique_ptr<Camera> device, const std::filesystem::path& file,
                                         std::vector<std::string>& notes);

}  // namespace shaker::calibration

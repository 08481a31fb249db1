#pragma once
// shakerd calibrate camera: scale, tilt and lens from pictures of a board, or the scale from a known length.
#include <array>
#include <optional>

#include "daemon/commands/calibrate/board_pictures.hpp"

namespace shaker::commands {

/// The quick way: two points of the picture whose distance is known.
struct KnownLength {
    double length_mm = 0, error_mm = 0;
    std::array<double, 4> ends_px{};  // x, y of either
    double ends_error_px = 0.5;
    std::array<int, 2> size_px{};  // of the picture
};

struct CameraOptions {
    BoardOptions board{};
    std::filesystem::path print{};              // write the board as a PDF and do nothing else
    std::vector<std::filesystem::path> from{};  // pictures on the base; empty: live
    std::vector<std::filesystem::path> raised{};
    std::optional<KnownLength> length{};
    BoardLead lead{};
    double distance_mm = 0;  // of pictures from files, by the operator; 0: telecentric
    double distance_error = 0.1, board_error = 2e-4, offset_error_mm = 0.05;
    double walker_mm = 0;  // height of the walker's plane; live: the highest of the view's targets
    calibration::AxisFrom axis = calibration::AxisFrom::settings;
    std::filesystem::path output{};   // empty: camera-NAME-DATE.toml
    std::filesystem::path corners{};  // CSV of the corners and their residuals; empty: none
    bool json = false;
};

/// Fits (fit_plane()), writes the calibration file and prints the results. Files are not overwritten.
/// InputError as from its parts.
void calibrate_camera(const CameraOptions& options);

}  // namespace shaker::commands

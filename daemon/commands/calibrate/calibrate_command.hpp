#pragma once
// shakerd calibrate accelerometer: gain matrix and offsets from attitudes at rest.
#include <filesystem>
#include <string>
#include <vector>

#include "calibration/estimate.hpp"

namespace shaker::commands {

struct CalibrateOptions {
    std::vector<std::filesystem::path> from{};  // CSV files; empty: from the rig, live
    std::string rig = "sim:";
    std::filesystem::path scene{};
    calibration::Estimate gravity{};  // m/s^2, at the place
    double hold_s = 2;
    std::filesystem::path
        output{};  // empty: accelerometer-DATE.toml; records of a live calibration go beside it
    bool json = false;
};

/// Fits (fit_tumble()), writes the calibration file and prints the results. Files are not overwritten.
/// InputError as from its parts.
void calibrate_accelerometer(const CalibrateOptions& options);

}  // namespace shaker::commands

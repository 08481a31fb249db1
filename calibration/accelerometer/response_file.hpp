#pragma once
// The file of an accelerometer's response: TOML with a checksum, named by rig files and kept by recordings.
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "calibration/accelerometer/response_fit.hpp"
#include "drivers/devices.hpp"

namespace shaker::calibration {

/// The content of a file: date (ISO 8601), name of the sensor (empty: any), the keys of rig files
/// (view_settings.hpp), the lines. findings: comments at its head.
std::string response_text(const std::string& date, const std::string& sensor, const FittedResponse& fit,
                          const std::vector<std::string>& findings);

/// The same device with the response of a file in its info(). `notes` receives one sentence. InputError names
/// the file: it cannot be read, was changed, is of another sensor, or the settings state a response as well.
std::unique_ptr<Accelerometer> with_response(std::unique_ptr<Accelerometer> device,
                                             const std::filesystem::path& file,
                                             std::vector<std::string>& notes);

}  // namespace shaker::calibration

#pragma once
// An accelerometer that is read by its calibration file.
#include <memory>
#include <string>
#include <vector>

#include "calibration/accelerometer/sensor_file.hpp"
#include "drivers/devices.hpp"

namespace shaker::calibration {

/// The same device with the gains and offsets of a calibration file in its info(). `notes` receives one
/// sentence: the file, its date and the errors of its gains. InputError as from calibrated().
std::unique_ptr<Accelerometer> with_calibration(std::unique_ptr<Accelerometer> device,
                                                const CalibrationFile& by, std::vector<std::string>& notes);

}  // namespace shaker::calibration

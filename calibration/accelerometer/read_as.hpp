#pragma once
// An accelerometer whose info() is another one than its driver's, by a calibration.
#include <memory>
#include <string>

#include "drivers/devices.hpp"

namespace shaker::calibration {

std::unique_ptr<Accelerometer> read_as(std::unique_ptr<Accelerometer> device, AccelerometerInfo info);

/// InputError where a calibration file was made of another sensor than that of `info`; addresses, which
/// change with the socket, may differ.
void require_sensor(const std::string& file, const std::string& made_of, const AccelerometerInfo& info);

}  // namespace shaker::calibration

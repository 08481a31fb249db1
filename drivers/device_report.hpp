#pragma once
// Sample counts of each device at the end of a run.
#include <string>
#include <vector>

#include "drivers/devices.hpp"

namespace shaker {

struct DeviceReport {
    std::string device;  // the device's name
    std::string what;    // unit of the counts: "samples", "frames"
    DeviceCounts counts;
};

/// Counts of DAC, accelerometer and cameras, in this order. Missing devices have no entry.
std::vector<DeviceReport> device_reports(const Rig& rig);

}  // namespace shaker

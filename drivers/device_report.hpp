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
inline std::vector<DeviceReport> device_reports(const Rig& rig) {
    std::vector<DeviceReport> reports;
    if (rig.dac) reports.push_back({rig.dac->info().name, "samples", rig.dac->counts()});
    if (rig.accelerometer)
        reports.push_back({rig.accelerometer->info().name, "samples", rig.accelerometer->counts()});
    for (const auto& camera : rig.cameras)
        reports.push_back({"camera \"" + camera->view().camera + "\"", "frames", camera->counts()});
    return reports;
}

}  // namespace shaker

#include "drivers/device_report.hpp"

namespace shaker {

std::vector<DeviceReport> device_reports(const Rig& rig) {
    std::vector<DeviceReport> reports;
    if (rig.dac) reports.push_back({rig.dac->info().name, "samples", rig.dac->counts()});
    if (rig.accelerometer)
        reports.push_back({rig.accelerometer->info().name, "samples", rig.accelerometer->counts()});
    for (const auto& camera : rig.cameras)
        reports.push_back({"camera \"" + camera->view().camera + "\"", "frames", camera->counts()});
    return reports;
}

}  // namespace shaker

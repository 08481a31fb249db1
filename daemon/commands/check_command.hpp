#pragma once
// shakerd check: a self-test of every device of a rig.
#include <filesystem>
#include <string>

namespace shaker::commands {

struct CheckOptions {
    std::string rig = "sim:";
    std::filesystem::path scene;  // file, for the simulated rig
    double frequency_hz = 20;
    double level = 0.02;  // amplitude of each of the two harmonics, share of the DAC's full scale
    bool json = false;
    bool commission = false;  // then lead the operator through the commissioning (daemon/commissioning)
};
/// Opens every device of a rig, plays a low-level self-test and prints the findings. False when a device is
/// not fit to run, or when the commissioning did not pass.
bool check(const CheckOptions& options);

}  // namespace shaker::commands

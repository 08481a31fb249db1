#pragma once
// shakerd devices: the connected devices.
#include "drivers/hardware/hardware_rig.hpp"

namespace shaker::commands {

struct DevicesOptions {
    hardware::Search search{};
    bool json = false;
};
/// Prints the connected devices and their capabilities with the keys of a rig file.
void list_devices(const DevicesOptions& options);

}  // namespace shaker::commands

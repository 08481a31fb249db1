#pragma once
// shakerd devices: the connected devices.
#include <filesystem>

#include "drivers/hardware/kinds.hpp"

namespace shaker::commands {

struct DevicesOptions {
    hardware::Search search{};
    bool json = false;
    std::filesystem::path unit{};  // rig file: print a drop-in of the service for it; empty: list devices
};
/// Prints the connected devices and their capabilities with the keys of a rig file, or the drop-in.
void list_devices(const DevicesOptions& options);

}  // namespace shaker::commands

#pragma once
// shakerd devices --unit: rights of the service for the devices of one bench.
#include <filesystem>
#include <string>

#include "drivers/hardware/kinds.hpp"

namespace shaker::commands {

/// A drop-in for shakerd.service: the device classes and the addresses of the rig file's devices, and no
/// other devices. InputError for a file that cannot be read or a device of unknown kind.
std::string unit_drop_in(const std::filesystem::path& rig, const hardware::Kinds& kinds = {});

}  // namespace shaker::commands

#pragma once
// What a client of the mock bench needs to find it: libasound's configuration and a rig file.
#include <cstdint>
#include <filesystem>
#include <string>

#include "drivers/mock/bench.hpp"

namespace shaker {

/// Serial number of the mock camera that plays the scene's camera `name`; its id is Shaker-Mock-<serial>.
std::string bench_serial(const std::string& name);

/// Writes asound.conf and rig.toml into the settings' folder; returns the latter's name. Throws DeviceError.
std::filesystem::path write_bench_files(const BenchSettings& settings, std::uint16_t iiod_port);

}  // namespace shaker

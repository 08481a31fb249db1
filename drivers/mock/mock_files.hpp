#pragma once
// Files for a client of the mock bench: libasound's configuration and a rig file.
#include <cstdint>
#include <filesystem>
#include <string>

#include "drivers/mock/mock_bench.hpp"

namespace shaker::mock {

/// Serial number of the mock camera for the scene's camera `name`; its id is Shaker-Mock-<serial>.
std::string bench_serial(const std::string& name);

/// Writes asound.conf and rig.toml into the settings' folder; returns the path of rig.toml. Throws
/// DeviceError.
std::filesystem::path write_bench_files(const MockBenchSettings& settings, std::uint16_t iiod_port);

}  // namespace shaker::mock

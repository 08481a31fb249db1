#pragma once
// shakerd example: a session of footage from the simulated bench.
#include <filesystem>

namespace shaker::commands {

/// Writes session.toml, top.mkv, side.mkv, accelerations.csv and truth.json into a folder, which is created
/// if needed: the simulated bench at 1 g, phi 0 and 20 Hz, 24 periods of the settled walker at 200 pictures
/// per second. The accelerations have their own clock. All files are identical each time, except that the
/// movies depend on the codec. Throws InputError when one of the files exists, DeviceError when one cannot be
/// written.
void write_example_session(const std::filesystem::path& folder);

}  // namespace shaker::commands

#pragma once
// An example of a session that shakerd did not record.
#include <filesystem>

namespace shaker::commands {

/// Writes session.toml, top.mkv, side.mkv, accelerations.csv and truth.json into a folder, which is made
/// where need be: the simulated bench driven with 1 g, phi 0 at 20 Hz, 24 periods of the settled walker at
/// 200 pictures a second. The accelerations have a clock of their own. The same bytes each time, but for the
/// movies' codec. Throws InputError when one of the files exists, DeviceError when one cannot be written.
void write_example_session(const std::filesystem::path& folder);

}  // namespace shaker::commands

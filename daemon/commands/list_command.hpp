#pragma once
// shakerd list: what recordings hold.
#include <filesystem>

namespace shaker::commands {

/// Prints time, outcome, remarks and measurements of a recording; json: all of it as one line of JSON.
void list_recording(const std::filesystem::path& file, bool json);

}  // namespace shaker::commands

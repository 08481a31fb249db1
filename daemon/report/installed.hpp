#pragma once
// Files that are installed with the program.
#include <filesystem>
#include <string_view>

namespace shaker::report {

/// The folder share/shakerd/NAME beside an installed program, or NAME in the folder of the build; empty when
/// there is neither.
std::filesystem::path installed(std::string_view name);

}  // namespace shaker::report

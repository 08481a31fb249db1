#pragma once
// Which settings differ between two texts of a TOML file.
#include <string>
#include <string_view>
#include <vector>

namespace shaker::bench {

/// Keys and tables of the top level that the texts do not both have with the same values, sorted. InputError
/// for a text that is not TOML.
std::vector<std::string> changed_settings(std::string_view before, std::string_view after);

}  // namespace shaker::bench

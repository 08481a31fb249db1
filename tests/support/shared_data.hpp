#pragma once
// Sessions that lie beside a checkout (../shared/data) because they are too large to be part of it.
#include <filesystem>
#include <string>
#include <string_view>

namespace shaker {

/// The folder of one data set; empty if the data are missing. If CI is set in the environment it throws
/// instead, so that a test that needs the data cannot pass without them.
std::filesystem::path shared_data(std::string_view name);

/// Why a test is skipped: the data set by its name, and that a clone does not have it.
std::string missing_data(std::string_view name);

}  // namespace shaker

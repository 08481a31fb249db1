#pragma once
// Sessions that lie beside a checkout (../shared/data) because they are too large to be part of it.
#include <filesystem>
#include <string>
#include <string_view>

namespace shaker {

/// The folder of one data set; empty if the data are missing. If CI is set in the environment it throws
/// instead, so that a test that needs the data cannot pass without them.
std::filesystem::path shared_data(std::string_view name);

/// Reason for a skipped test: the name of the missing data set, which a clone does not have.
std::string missing_data(std::string_view name);

}  // namespace shaker

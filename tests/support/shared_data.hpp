#pragma once
// Measured and computed sessions that lie beside a checkout (../shared/data) and are too large to be part of
// it.
#include <filesystem>
#include <string_view>

namespace shaker {

/// The folder of one data set. Empty where the data are not there; throws instead when CI is set in the
/// environment, so that a test which needs them cannot pass there without them.
std::filesystem::path shared_data(std::string_view name);

}  // namespace shaker

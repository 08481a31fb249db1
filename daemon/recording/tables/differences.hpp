#pragma once
// Comparison of a recording with values that were computed again.
#include <string>
#include <vector>

#include "daemon/recording/tables/columns.hpp"

namespace shaker::recording {

/// Bitwise differences between the recording and the given numbers and tables, one sentence each. NaN equals
/// NaN.
std::vector<std::string> differences(const recorded::RecordingReader& file,
                                     const std::vector<RecordedNumber>& numbers,
                                     const std::vector<RecordedTable>& tables);

}  // namespace shaker::recording

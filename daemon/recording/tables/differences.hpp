#pragma once
// A recording held against what was computed again.
#include <string>
#include <vector>

#include "daemon/recording/tables/columns.hpp"

namespace shaker::recording {

/// Where the recording's numbers and tables are not, to the bit, the ones given: one sentence each. NaN
/// equals NaN.
std::vector<std::string> differences(const recorded::RecordingReader& file,
                                     const std::vector<RecordedNumber>& numbers,
                                     const std::vector<RecordedTable>& tables);

}  // namespace shaker::recording

#pragma once
// Comparison of a recording with values and tracks that were computed again.
#include <string>
#include <vector>

#include "daemon/acquisition/streams.hpp"
#include "daemon/recording/tables/columns.hpp"
#include "drivers/recorded/recording_file.hpp"

namespace shaker::recording {

/// Bitwise differences between the recording and the given numbers and tables, one sentence each. NaN equals
/// NaN.
std::vector<std::string> differences(const recorded::RecordingReader& file,
                                     const std::vector<RecordedNumber>& numbers,
                                     const std::vector<RecordedTable>& tables);

/// One sentence for each target whose places differ from the recorded ones.
std::vector<std::string> track_changes(const recorded::RecordingReader& file,
                                       const acquisition::Streams& now);

}  // namespace shaker::recording

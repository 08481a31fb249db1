#pragma once
// What a recording has places for beside the raw streams: made from what an empty run would write, so that
// there is one list.
#include <string>
#include <vector>

#include "daemon/recorder.hpp"
#include "drivers/replay/session_file.hpp"

namespace shaker {

/// Places for a table's columns, for numbers whose paths begin with `path`.
GroupLayout layout_of(const RecordedTable& table, double rows_per_s = 0);
GroupLayout layout_of(const std::string& path, const std::vector<RecordedNumber>& numbers);

/// For a header whose views are known. truth: of a simulated rig.
std::vector<GroupLayout> session_places(const SessionHeader& header, bool truth);

}  // namespace shaker

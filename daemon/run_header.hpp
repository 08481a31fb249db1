#pragma once
// What a recording of a run says of it before the first sample.
#include "daemon/commands.hpp"
#include "daemon/rigs.hpp"
#include "drivers/replay/session_file.hpp"

namespace shaker {

/// live: on real time, with a date and an identifier. with_truth: places for where a simulated walker really
/// was.
SessionHeader run_header(const OpenRig& bench, const RunOptions& run, bool live, bool with_truth);

}  // namespace shaker

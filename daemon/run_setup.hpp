#pragma once
// What a run begins with: what its recording says of it before the first sample, what it will ask of
// the bench, its plan.
#include <vector>

#include "daemon/commands.hpp"
#include "daemon/control/envelope.hpp"
#include "daemon/director.hpp"
#include "daemon/rigs.hpp"
#include "drivers/replay/session_file.hpp"

namespace shaker {

/// live: on real time, with a date and an identifier. with_truth: places for where a simulated walker really
/// was.
SessionHeader run_header(const OpenRig& bench, const RunOptions& run, bool live, bool with_truth);
/// What a drive will ask of this bench, by its data sheet, beside these limits.
std::vector<Demand> run_demands(const OpenRig& bench, const Drive& drive, const Limits& limits);
RunPlan run_plan(const OpenRig& bench, const RunOptions& run, const Limits& limits);

}  // namespace shaker

#pragma once
// What a run begins with: what its recording says of it before the first sample, what it will ask of
// the bench, its plan.
#include <vector>

#include "daemon/bench/bench.hpp"
#include "daemon/run/run_settings.hpp"
#include "daemon/run/sequence.hpp"
#include "daemon/safety/preflight.hpp"
#include "drivers/recorded/recording_file.hpp"

namespace shaker::run {

/// live: on real time, with a date and an identifier. with_truth: places for where a simulated walker really
/// was.
recorded::RecordingHeader run_header(const bench::Bench& bench, const RunOptions& run, bool live,
                                     bool with_truth);
/// The limits of any run: those of the bench, but the DAC may run empty, for the drive comes up softly again
/// by itself some times.
safety::Limits limits_of_run(safety::Limits limits);
/// What a drive will ask of this bench, by its data sheet, beside these limits.
std::vector<safety::Demand> run_demands(const bench::Bench& bench, const Drive& drive,
                                        const safety::Limits& limits);
RunPlan run_plan(const bench::Bench& bench, const RunOptions& run, const safety::Limits& limits);

}  // namespace shaker::run

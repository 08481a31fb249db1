#pragma once
// Runs an opened rig: output, sensors and whoever leads, in lockstep or one thread each.
#include <functional>

#include "daemon/acquisition/collector.hpp"
#include "daemon/acquisition/executors.hpp"
#include "daemon/acquisition/steps.hpp"
#include "daemon/bench/bench.hpp"

namespace shaker::acquisition {

/// Frame rate of the trigger train: that of the cameras that the DAC triggers (0: there is none). InputError
/// when two of them differ: one train serves all.
double trigger_rate(const Rig& rig);

/// What leads a run: looks at the take, may post to the loops; false when nothing had come.
using Lead = std::function<bool(const Streams&, Channels&)>;

/// Whether a run on this rig has one thread a loop: hardware has, whatever was asked for.
bool runs_threaded(const bench::Bench& bench, bool threads);
/// Until `done`, which is asked after each call of `lead`. recorder: writes what was gathered.
Execution run_loops(bench::Bench& bench, Collector& collector, DriveOutput& output, bool threads,
                    const Lead& lead, const std::function<bool()>& done,
                    const std::function<bool()>& recorder = {});

}  // namespace shaker::acquisition

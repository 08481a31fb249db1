#pragma once
// Runs an opened rig: output, sensors and the leader of the run, in lockstep or in one thread each.
#include <functional>
#include <vector>

#include "daemon/acquisition/collector.hpp"
#include "daemon/acquisition/drive_output.hpp"
#include "daemon/acquisition/executors.hpp"
#include "daemon/acquisition/steps.hpp"
#include "daemon/bench/bench.hpp"

namespace shaker::acquisition {

/// Rate of the trigger pulses, Hz: the frame rate of the cameras that the DAC triggers; without one
/// DacInfo::pulse_hz. InputError when the rates differ, because one pulse train serves all cameras.
double trigger_rate(const Rig& rig);

/// Leads a run: reads the streams and posts to the loops. False when no data arrived.
using Lead = std::function<bool(const Streams&, Channels&)>;

/// True when a run on this rig has one thread per loop. Hardware always does; `threads` requests it
/// otherwise.
bool runs_threaded(const bench::Bench& bench, bool threads);
/// Who leads the loops.
struct Leader {
    Lead lead;                         // called after new data
    std::function<bool()> done;        // called after `lead`
    std::function<bool()> recorder{};  // writes the gathered data; empty: no such loop
    std::function<void(const std::vector<RealTimeGrant>&)> begun  // as RunHooks::begun
        = [](const std::vector<RealTimeGrant>&) {};
};
/// Runs all loops until `done`. Loops that fail: the drive ramps to zero, then the exception is thrown from
/// here. Simulated rigs take no real-time priority. Returns the real time, s.
double run_loops(bench::Bench& bench, Collector& collector, DriveOutput& output, bool threads,
                 const Leader& leader);

}  // namespace shaker::acquisition

#pragma once
// Runs an opened rig: output, sensors and whoever leads, in lockstep or one thread each.
#include <functional>

#include "daemon/acquisition.hpp"
#include "daemon/executors.hpp"
#include "daemon/loops.hpp"
#include "daemon/results.hpp"
#include "daemon/rigs.hpp"

namespace shaker {

/// Frame rate of the trigger train: that of the cameras that the DAC triggers (0: there is none). InputError
/// when two of them differ: one train serves all.
double trigger_rate(const Rig& rig);

/// What leads a run: looks at the take, may post to the loops; false when nothing had come.
using Lead = std::function<bool(const Take&, Lanes&)>;

/// Whether a run on this rig has one thread a loop: hardware has, whatever was asked for.
bool runs_threaded(const OpenRig& bench, bool threads);
/// Until `done`, which is asked after each call of `lead`. recorder: writes what was gathered.
Execution drive_rig(OpenRig& bench, Acquisition& acquisition, Output& output, bool threads, const Lead& lead,
                    const std::function<bool()>& done, const std::function<bool()>& recorder = {});

/// What every device has counted: the DAC, the accelerometer, the cameras.
std::vector<DeviceReport> device_reports(const Rig& rig);

}  // namespace shaker

#pragma once
// One step function a loop. On hardware each runs in its own thread, on a simulated or replayed rig the
// lockstep executor calls the same functions. A step touches one device and a few rings and nothing else.
#include <chrono>
#include <vector>

#include "daemon/lanes.hpp"
#include "drivers/devices.hpp"
#include "drivers/synthesiser.hpp"
#include "drivers/trigger_train.hpp"
#include "tracking/tracker.hpp"

namespace shaker {

/// What the output loop owns: synthesiser, trigger train and their block of samples.
struct Output {
    /// block: samples a write.
    Output(const DacInfo& dac, double frequency, double frames_per_second, std::size_t block);
    Synthesiser synthesiser;
    TriggerTrain triggers;
    std::vector<double> volts, pulses;
};

/// Takes the newest drive, fills one block and plays it. Real-time but for Dac::write.
void output_step(Output& output, Dac& dac, Lanes& lanes);

/// Hands on the next block. False when none came within `wait`. Real-time but for Accelerometer::read.
bool accelerometer_step(Accelerometer& device, std::chrono::milliseconds wait, Lanes& lanes);

/// Takes a frame, finds the targets while it is warm in the cache, hands both on. False when none came.
/// Without room to hand it on the frame is counted as lost.
bool camera_step(Camera& device, ViewTracker& tracker, std::chrono::milliseconds wait,
                 Ring<TrackedFrame>& out, Counters& lost);

}  // namespace shaker

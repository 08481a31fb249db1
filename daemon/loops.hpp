#pragma once
// One step function a loop. On hardware each runs in its own thread, on a simulated or replayed rig the
// lockstep executor calls the same functions. A step touches one device and a few rings and nothing else.
#include <chrono>
#include <cstdint>
#include <memory>
#include <vector>

#include "daemon/control/drive_guard.hpp"
#include "daemon/control/sample_guard.hpp"
#include "daemon/lanes.hpp"
#include "drivers/devices.hpp"
#include "drivers/synthesiser.hpp"
#include "drivers/trigger_train.hpp"
#include "tracking/tracker.hpp"

namespace shaker {

/// What the output loop owns: synthesiser, its guard, trigger train and their block of samples.
struct Output {
    /// block: samples a write. limits: none, or those the guard enforces; no sample leaves beyond the drive's
    /// abort level then. accelerometer_rate_hz: of the one whose silence stops the drive; 0: there is none.
    Output(const DacInfo& dac, double frequency, double frames_per_second, std::size_t block,
           const std::optional<Limits>& limits = {}, double accelerometer_rate_hz = 0);
    Synthesiser synthesiser;
    DriveGuard guard;
    TriggerTrain triggers;
    std::vector<double> volts, pulses;
    std::int64_t lost = 0;       // samples the DAC stood empty behind the last block
    std::uint64_t released = 0;  // Lanes::releases that were answered
    std::uint64_t aborted = 0;   // Lanes::aborts likewise
};

/// What the accelerometer's loop owns.
struct Input {
    SampleGuard guard;
    std::uint64_t released = 0;  // Lanes::releases that were answered
    std::uint64_t heard = 0;     // Accelerometer::heard() of the last step
};

/// What a camera's loop owns.
struct Eye {
    explicit Eye(const View& view) : tracker{view} {}
    ViewTracker tracker;
    Ring<std::shared_ptr<ViewTracker>> fresh{2};  // from the reduction: takes over with the next frame
    std::uint64_t learned = 0;                    // how many took over
};

/// Answers trips, its own among them, and the operator's release, takes the newest drive, fills one block and
/// plays it. A stop begins with that block's first sample. Real-time but for Dac::write.
void output_step(Output& output, Dac& dac, Lanes& lanes);

/// Judges the next block and hands it on. False when none came within `wait`. Real-time but for
/// Accelerometer::read.
bool accelerometer_step(Input& input, Accelerometer& device, std::chrono::milliseconds wait, Lanes& lanes);

/// Takes a frame, finds the targets while it is warm in the cache, hands both on. False when none came.
/// Without room to hand it on the frame is counted as lost. A fresh tracker that does not find its targets in
/// the frame is counted, and the one before goes on.
bool camera_step(Camera& device, Eye& eye, std::chrono::milliseconds wait, Ring<TrackedFrame>& out,
                 Counters& lost);

}  // namespace shaker

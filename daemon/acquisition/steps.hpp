#pragma once
// One step function a loop. On hardware each runs in its own thread, on a simulated or replayed rig the
// lockstep executor calls the same functions. A step touches one device and a few rings and nothing else.
#include <chrono>
#include <cstdint>
#include <memory>
#include <vector>

#include "daemon/acquisition/channels.hpp"
#include "daemon/safety/output_guard.hpp"
#include "daemon/safety/sample_guard.hpp"
#include "drivers/devices.hpp"
#include "drivers/synthesiser.hpp"
#include "drivers/trigger_train.hpp"
#include "tracking/tracker.hpp"

namespace shaker::acquisition {

/// What the output loop owns: synthesiser, its guard, trigger train and their block of samples.
struct DriveOutput {
    /// block: samples a write. limits: none, or those the guard enforces; no sample leaves beyond the drive's
    /// abort level then. accelerometer_rate_hz: of the one whose silence stops the drive; 0: there is none.
    DriveOutput(const DacInfo& dac, double frequency, double frames_per_second, std::size_t block,
                const std::optional<safety::Limits>& limits = {}, double accelerometer_rate_hz = 0);
    Synthesiser synthesiser;
    safety::OutputGuard guard;
    TriggerTrain triggers;
    std::vector<double> volts, pulses;
    std::int64_t lost = 0;       // samples the DAC stood empty behind the last block
    std::uint64_t released = 0;  // Lanes::releases that were answered
    std::uint64_t aborted = 0;   // Lanes::aborts likewise
};

/// What the accelerometer's loop owns.
struct AccelerometerInput {
    safety::SampleGuard guard;
    std::uint64_t released = 0;  // Lanes::releases that were answered
    std::uint64_t heard = 0;     // Accelerometer::heard() of the last step
};

/// What a camera's loop owns.
struct CameraInput {
    explicit CameraInput(const View& view) : tracker{view} {}
    tracking::ViewTracker tracker;
    Ring<std::shared_ptr<tracking::ViewTracker>> fresh{
        2};                     // from the reduction: takes over with the next frame
    std::uint64_t learned = 0;  // how many took over
};

/// Answers trips, its own among them, and the operator's release, takes the newest drive, fills one block and
/// plays it. A stop begins with that block's first sample. Real-time but for Dac::write.
void output_step(DriveOutput& output, Dac& dac, Channels& channels);

/// Judges the next block and hands it on. False when none came within `wait`. Real-time but for
/// Accelerometer::read.
bool accelerometer_step(AccelerometerInput& input, Accelerometer& device, std::chrono::milliseconds wait,
                        Channels& channels);

/// Takes a frame, finds the targets while it is warm in the cache, hands both on. False when none came.
/// Without room to hand it on the frame is counted as lost. A fresh tracker that does not find its targets in
/// the frame is counted, and the one before goes on.
bool camera_step(Camera& device, CameraInput& camera_input, std::chrono::milliseconds wait,
                 Ring<TrackedFrame>& out, Counters& lost);

}  // namespace shaker::acquisition

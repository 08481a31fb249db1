#pragma once
// One step function per loop. On hardware each runs in its own thread; on a simulated or replayed rig the
// lockstep executor calls the same functions. A step uses one device and a few rings.
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

/// State of the output loop: synthesiser, guard, trigger train and their blocks of samples.
struct DriveOutput {
    /// block: samples per write. limits: enforced by the guard; every sample stays below the drive's abort
    /// level; empty: no guard. accelerometer_rate_hz: of the accelerometer whose silence stops the drive;
    /// 0: no accelerometer.
    DriveOutput(const DacInfo& dac, double frequency, double frames_per_second, std::size_t block,
                const std::optional<safety::Limits>& limits = {}, double accelerometer_rate_hz = 0);
    Synthesiser synthesiser;
    safety::OutputGuard guard;
    TriggerTrain triggers;
    std::vector<double> volts, pulses;
    std::int64_t lost = 0;       // samples during which the DAC was empty after the last block
    std::uint64_t released = 0;  // value of Channels::releases that was answered
    std::uint64_t aborted = 0;   // value of Channels::aborts that was answered
};

/// State of the accelerometer's loop.
struct AccelerometerInput {
    safety::SampleGuard guard;
    std::uint64_t released = 0;  // value of Channels::releases that was answered
    std::uint64_t heard = 0;     // Accelerometer::heard() of the last step
};

/// State of a camera's loop.
struct CameraInput {
    explicit CameraInput(const View& view) : tracker{view} {}
    tracking::ViewTracker tracker;
    /// Trackers from the reduction; each replaces `tracker` at the next frame.
    Ring<std::shared_ptr<tracking::ViewTracker>> fresh{2};
    std::uint64_t learned = 0;  // fresh trackers that were tried
};

/// Answers trips (also its own) and releases, takes the newest drive, fills one block and plays it. A stop
/// starts with the first sample of that block. Real-time except for Dac::write.
void output_step(DriveOutput& output, Dac& dac, Channels& channels);

/// Checks the next block and passes it on. False when no block arrived within `wait`. Real-time except for
/// Accelerometer::read.
bool accelerometer_step(AccelerometerInput& input, Accelerometer& device, std::chrono::milliseconds wait,
                        Channels& channels);

/// Takes a frame, finds its targets while it is in the cache, and passes both on. False when no frame arrived
/// within `wait`. A frame that finds a full ring is counted as lost. A fresh tracker that does not find its
/// targets is counted, and the previous one continues.
bool camera_step(Camera& device, CameraInput& camera_input, std::chrono::milliseconds wait,
                 Ring<TrackedFrame>& out, Counters& lost);

}  // namespace shaker::acquisition

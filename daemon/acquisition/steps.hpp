#pragma once
// One step function per sensor loop (drive_output.hpp has the output's). On hardware each runs in its own
// thread; on a simulated or replayed rig the lockstep executor calls the same functions. A step uses one
// device and a few rings.
#include <chrono>
#include <cstdint>
#include <memory>

#include "daemon/acquisition/channels.hpp"
#include "daemon/safety/sample_guard.hpp"
#include "drivers/devices.hpp"
#include "tracking/tracker.hpp"

namespace shaker::acquisition {

/// State of the accelerometer's loop.
struct AccelerometerInput {
    safety::SampleGuard guard;
    std::uint64_t released = 0;  // value of Channels::releases that was answered
};

/// State of a camera's loop.
struct CameraInput {
    explicit CameraInput(const View& view) : tracker{view} {}
    tracking::ViewTracker tracker;
    /// Trackers from the reduction; each replaces `tracker` at the next frame.
    Ring<std::shared_ptr<tracking::ViewTracker>> fresh{2};
    std::uint64_t learned = 0;  // fresh trackers that were tried
    bool begun = false;         // a picture has been tracked
    bool patient = false;       // a tracker that does not find its targets at the start searches again
    std::string not_found;      // why it has not found them
    std::uint64_t unfound = 0;  // frames without them
};

/// Checks the next block and passes it on. False when no block arrived within `wait`. Real-time except for
/// Accelerometer::read.
bool accelerometer_step(AccelerometerInput& input, Accelerometer& device, std::chrono::milliseconds wait,
                        Channels& channels);

/// Takes a frame, finds its targets while it is in the cache, and passes both on. False when no frame arrived
/// within `wait`. A frame that finds a full ring is counted as lost. A fresh tracker that does not find its
/// targets is counted, and the previous one continues. The first tracker throws InputError then; a patient
/// input passes the frame on without positions. tracking: gets the time per picture.
bool camera_step(Camera& device, CameraInput& camera_input, std::chrono::milliseconds wait,
                 Ring<TrackedFrame>& out, Counters& lost, TimeHistogram& tracking);

/// Reads the contact and passes on that it has opened or cannot be read. Waits at most `wait` for a change.
void abort_input_step(AbortInput& device, std::chrono::milliseconds wait, Channels& channels);

}  // namespace shaker::acquisition

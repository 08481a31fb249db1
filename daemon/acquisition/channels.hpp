#pragma once
// Everything that crosses threads in one run: bounded rings, newest-value mailboxes, counters of what was
// lost.
#include <atomic>
#include <list>
#include <vector>

#include "daemon/acquisition/period_jitter.hpp"
#include "daemon/safety/limits.hpp"
#include "daemon/safety/predicted_motion.hpp"
#include "daemon/safety/trip.hpp"
#include "drivers/data.hpp"
#include "drivers/handover.hpp"
#include "drivers/synthesiser.hpp"
#include "tracking/track.hpp"

namespace shaker::acquisition {

/// A frame with where its targets are, in the order of the view's targets.
struct TrackedFrame {
    FramePtr frame;
    std::vector<tracking::Fix> fixes;
    std::uint64_t learned = 0;  // Eye::learned of the tracker that found them
};

/// What did not fit into a ring: never waited for, always counted.
struct Counters {
    std::atomic<std::uint64_t> plays_lost{0};
    std::atomic<std::uint64_t> changes_lost{0};
    std::atomic<std::uint64_t> blocks_lost{0};
    std::atomic<std::uint64_t> frames_lost{0};
    std::atomic<std::uint64_t> samples_clamped{0};
    std::atomic<std::uint64_t> trips_lost{0};
    std::atomic<std::uint64_t> not_learned{0};  // targets that were to be learned anew and were not there
};

/// Rings of samples hold 10 s and more of the paper's rates; those of frames hold less than a camera's pool
/// has.
struct Channels {
    explicit Channels(std::size_t cameras) {
        for (std::size_t i = 0; i < cameras; ++i) frames.emplace_back(128);
    }
    Mailbox<DriveCommand> drive;  // reduction to output: the one back arrow
    // The way of a trip: whoever finds it, the output stops within its next block and tells the reduction.
    Ring<safety::Trip> sensed{8};   // accelerometer to output
    Ring<safety::Trip> ordered{8};  // reduction to output: its own findings and the operator's stop
    Ring<safety::Trip> trips{64};   // output to reduction, in order: the first since a release is the cause
    std::atomic<std::uint64_t> aborts{0};           // raised by anybody, at any time, to stop
    std::atomic<std::uint64_t> aborts_answered{0};  // by the output, after its trip
    std::atomic<bool> stopped{false};               // the output is latched: it refuses commands
    std::atomic<std::uint64_t> releases{0};    // raised by the reduction to unlatch, as soon as it is silent
    Mailbox<safety::Expectation> expectation;  // reduction to accelerometer
    Mailbox<safety::Limits> output_limits, input_limits;  // reduction to output and accelerometer
    Ring<DriveChange> ahead{64};                  // output to accelerometer: what is about to be heard
    std::atomic<std::uint64_t> signs_of_life{0};  // of the accelerometer
    safety::Warnings warnings;
    Ring<PlayTime> played{8192};  // output to reduction
    Ring<DriveChange> changes{1024};
    Ring<AccelBlock> blocks{1024};
    std::list<Ring<TrackedFrame>> frames;
    std::atomic<std::int64_t> gathered{
        0};  // DAC sample up to which the reduction has gathered what was played
    Counters lost;
    PeriodJitter jitter;  // of the output, on real time
};

}  // namespace shaker::acquisition

#pragma once
// All data that cross threads in a run: bounded rings, mailboxes for newest values, counters of lost data.
#include <atomic>
#include <list>
#include <string>
#include <vector>

#include "daemon/acquisition/time_histogram.hpp"
#include "daemon/safety/limits.hpp"
#include "daemon/safety/predicted_motion.hpp"
#include "daemon/safety/trip.hpp"
#include "drivers/data.hpp"
#include "drivers/devices.hpp"
#include "drivers/handover.hpp"
#include "drivers/synthesiser.hpp"
#include "tracking/tracker.hpp"

namespace shaker::acquisition {

/// A frame with the positions of its targets, in the order of the view's targets.
struct TrackedFrame {
    FramePtr frame;
    std::vector<tracking::Fix> fixes;
    std::uint64_t learned = 0;  // CameraInput::learned of the tracker that found them
    std::string not_found{};    // why the tracker could not learn its targets yet; empty: it follows them
};

/// Counters of data that found a full ring. Writers never wait.
struct Counters {
    std::atomic<std::uint64_t> plays_lost{0};
    std::atomic<std::uint64_t> changes_lost{0};
    std::atomic<std::uint64_t> blocks_lost{0};
    std::atomic<std::uint64_t> frames_lost{0};
    std::atomic<std::uint64_t> samples_clamped{0};
    std::atomic<std::uint64_t> trips_lost{0};
    std::atomic<std::uint64_t> not_learned{0};  // fresh trackers that did not find their targets
};

/// An operator's clear. The silent output unlatches if no trip, no abort and no opening of the contact came
/// after it.
struct Clearance {
    std::uint64_t trips = 0;     // Trip::number of the newest trip that the operator has seen
    std::uint64_t aborts = 0;    // Channels::aborts when the operator cleared
    std::uint64_t openings = 0;  // Channels::openings when the operator cleared
};

/// Why the loop of a camera ended; the run goes on without that camera.
struct LoopFailure {
    std::string why;  // written before `failed`
    std::atomic<bool> failed{false};
};

/// Rings of samples hold at least 10 s at the paper's rates. Rings of frames hold fewer frames than a
/// camera's pool.
struct Channels {
    explicit Channels(std::size_t cameras) {
        for (std::size_t i = 0; i < cameras; ++i) {
            frames.emplace_back(128);
            cameras_failed.emplace_back();
            tracking.emplace_back();
        }
    }
    /// Reduction to output: the only feedback path. The output refuses a command whose author has not seen
    /// the newest underrun, except soft stops.
    Mailbox<DriveCommand> drive;
    // Trips from all threads go to the output. It stops within its next block and reports to the reduction.
    Ring<safety::Trip> sensed{8};   // accelerometer to output
    Ring<safety::Trip> ordered{8};  // reduction to output: its own trips and the operator's stop
    Ring<safety::Trip> trips{64};   // output to reduction, in order: the first since a release is the cause
    std::atomic<std::uint64_t> excused{0};          // trips in `ordered` that were part of an underrun
    std::atomic<std::uint64_t> aborts{0};           // any thread increments it to stop the drive
    std::atomic<std::uint64_t> aborts_answered{0};  // set by the output after its trip
    // Abort input to output: number of times that its contact has opened, number of readings, newest state.
    std::atomic<std::uint64_t> openings{0}, contact_reads{0};
    std::atomic<Contact> contact{Contact::closed};
    std::atomic<bool> enabled{false};          // the enable output of the amplifier is on
    std::atomic<bool> stopped{false};          // the output is latched and refuses commands
    std::atomic<std::int64_t> silent{0};       // samples for which the output has been silent
    std::atomic<int> failed{-1};               // cause for which the output must stop, because a loop failed
    Mailbox<Clearance> clearance;              // reduction to output: an operator's clear
    std::atomic<std::uint64_t> releases{0};    // the output increments it when it has unlatched
    Mailbox<safety::Expectation> expectation;  // reduction to accelerometer
    Mailbox<safety::Limits> output_limits, input_limits;  // reduction to output and accelerometer
    Ring<DriveChange> ahead{64};           // output to accelerometer: changes before they are audible
    std::atomic<std::uint64_t> heard{0};   // samples of the accelerometer whose level was checked
    std::atomic<std::uint64_t> judged{0};  // blocks of the accelerometer that were checked completely
    // Newest sample that was checked completely: the tick after it, and its AccelBlock::arrived.
    std::atomic<std::int64_t> checked_to{0};
    std::atomic<HostTime> checked_arrived{};
    safety::Warnings warnings;
    Ring<PlayTime> played{8192};  // output to reduction
    Ring<DriveChange> changes{1024};
    Ring<AccelBlock> blocks{1024};
    std::list<Ring<TrackedFrame>> frames;
    std::list<LoopFailure> cameras_failed;  // one for each camera
    std::atomic<std::int64_t> gathered{0};  // newest DAC sample of which the reduction has the PlayTime
    Counters lost;
    PeriodJitter jitter;                // of the output in real time
    std::list<TimeHistogram> tracking;  // of each camera: how long it took to track a picture
};

}  // namespace shaker::acquisition

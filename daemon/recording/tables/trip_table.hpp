#pragma once
// A trip in a recording and in the results, the table "trips", and selection of the last seconds of a stopped
// run.
#include <spdlog/fmt/fmt.h>

#include <cmath>
#include <string>
#include <vector>

#include "daemon/acquisition/streams.hpp"
#include "daemon/recording/tables/run_tables.hpp"
#include "daemon/safety/trip.hpp"
#include "drivers/recorded/recording_file.hpp"

namespace shaker::recording {

/// A trip with its time and the state of the run.
struct RecordedTrip {
    safety::Trip trip;
    std::string state;  // of the run: "identify"
    double at_s = 0;    // master time of the sample that violated the limit; NaN: clock not known yet
};

/// "at 3.021 s in state run: peak acceleration of the base 61 m/s^2 exceeds the limit of 60 m/s^2; ..."
inline std::string text(const RecordedTrip& trip) {
    const std::string when = std::isfinite(trip.at_s) ? fmt::format("at {:.3f} s ", trip.at_s) : "";
    return fmt::format("{}in state {}: {}", when, trip.state, text(trip.trip));
}

/// Places of the table "trips".
std::vector<recorded::GroupLayout> trip_places();
void write_trips(recorded::RecordingWriter& file, const std::vector<RecordedTrip>& trips);
/// The recorded trips; empty for a run without a stop. InputError names an error in the table.
std::vector<RecordedTrip> read_trips(const recorded::RecordingReader& file);

/// The streams from master time from_s (s) on, with the drive that was in force at from_s. Times must be
/// settled. If blocks before from_s are omitted, the first block is marked as coming after a gap.
acquisition::Streams tail_of(const acquisition::Streams& streams, double from_s);

/// The whole periods of `planned` until two periods before a trip at master time at_s (s); the last two may
/// already show its cause. Empty (to_s <= from_s) when fewer than two periods remain.
MeasuredPart part_before(const MeasuredPart& planned, double at_s, double frequency_hz);

}  // namespace shaker::recording

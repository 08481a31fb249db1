#pragma once
// The table "trips", and selection of the last seconds of a stopped run.
#include <string>
#include <vector>

#include "daemon/acquisition/streams.hpp"
#include "daemon/recording/tables/recorded_trip.hpp"
#include "daemon/recording/tables/run_tables.hpp"
#include "drivers/recorded/recording_file.hpp"

namespace shaker::recording {

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

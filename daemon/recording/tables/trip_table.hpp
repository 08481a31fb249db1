#pragma once
// Why a run was stopped, as its recording says it, and the recording of a run's last seconds.
#include <string>
#include <vector>

#include "daemon/acquisition/streams.hpp"
#include "daemon/recording/tables/recorded_trip.hpp"
#include "daemon/recording/tables/run_tables.hpp"
#include "drivers/recorded/recording_file.hpp"

namespace shaker::recording {

/// What the table "trips" needs places for.
std::vector<recorded::GroupLayout> trip_places();
/// The table "trips".
void write_trips(recorded::RecordingWriter& file, const std::vector<RecordedTrip>& trips);
/// As they were written; empty for a run that ended well. InputError naming what is wrong in the table.
std::vector<RecordedTrip> read_trips(const recorded::RecordingReader& file);

/// What a take, whose times are settled, holds from master time from_s on, with the drive that was in force
/// then. Where something was left out before it, the first block is marked as coming after a gap.
acquisition::Streams tail_of(const acquisition::Streams& streams, double from_s);

/// What was measured before a trip at at_s: all but the last two periods before it, which may show what led
/// to it. Empty (to_s <= from_s) when that is less than two periods.
MeasuredPart part_before(const MeasuredPart& planned, double at_s, double frequency_hz);

}  // namespace shaker::recording

#pragma once
// Why a run was stopped, as its recording says it, and the recording of a run's last seconds.
#include <string>
#include <vector>

#include "daemon/director.hpp"
#include "daemon/recorded_trip.hpp"
#include "daemon/run_log.hpp"
#include "daemon/take.hpp"
#include "drivers/replay/session_file.hpp"

namespace shaker {

/// Why a run was stopped in the end, first of all the director's trip(): those of a take from then on, in
/// their order. A trip that was excused or cleared before is not among them.
std::vector<RecordedTrip> recorded_trips(const Take& take, const Director& director);
/// What the table "trips" needs places for.
std::vector<GroupLayout> trip_places();
/// The table "trips".
void write_trips(SessionWriter& file, const std::vector<RecordedTrip>& trips);
/// As they were written; empty for a run that ended well. InputError naming what is wrong in the table.
std::vector<RecordedTrip> read_trips(const SessionReader& file);

/// What a take, whose times are settled, holds from master time from_s on, with the drive that was in force
/// then. Where something was left out before it, the first block is marked as coming after a gap.
Take tail_of(const Take& take, double from_s);

/// What was measured before a trip at at_s: all but the last two periods before it, which may show what led
/// to it. Empty (to_s <= from_s) when that is less than two periods.
MeasuredPart part_before(const MeasuredPart& planned, double at_s, double frequency_hz);

}  // namespace shaker

#pragma once
// Hands the streams of a finished run to the thread that completes its recording.
#include "daemon/acquisition/streams.hpp"

namespace shaker::acquisition {

/// Moves all gathered data out of `streams` without copying; an hour of streams is a gigabyte. `streams`
/// keeps copies of the data since master time `keep_from_s`, of the drive in force at that time and of all
/// trips, and the time base of the bench. The result has the time base of its own stamps.
Streams hand_over(Streams& streams, double keep_from_s);

}  // namespace shaker::acquisition

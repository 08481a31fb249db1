#pragma once
// The streams of a run that is over, handed to the thread that completes its recording.
#include "daemon/acquisition/streams.hpp"

namespace shaker::acquisition {

/// Moves everything gathered so far out, without copying it: an hour of streams is a gigabyte. A copy of what
/// came since `keep_from_s` of master time, of the drive in force then and of all trips stays, and the time
/// base of the bench; what is moved out has the one of its own stamps.
Streams hand_over(Streams& streams, double keep_from_s);

}  // namespace shaker::acquisition

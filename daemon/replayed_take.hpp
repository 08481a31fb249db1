#pragma once
// What a recording holds, as a Take.
#include <string>
#include <vector>

#include "daemon/take.hpp"
#include "drivers/replay/session_file.hpp"

namespace shaker {

/// The raw streams of a recording, and its tracks: from the pictures, or as they were stored, in metres by
/// the views of `header`. real_time: as slowly as they were recorded, and told second by second.
Take replayed_take(const SessionReader& file, const SessionHeader& header, bool pictures, bool real_time,
                   std::vector<std::string>& notes);

/// Of a recording that was never finished: with stored tracks, whose times are found from the frames' stamps.
Take stored_take(const SessionReader& file, std::vector<std::string>& notes);

}  // namespace shaker

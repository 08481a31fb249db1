#pragma once
// What a recording holds, as a Take.
#include <string>
#include <vector>

#include "daemon/acquisition/streams.hpp"
#include "drivers/recorded/recording_file.hpp"

namespace shaker::recording {

/// The raw streams of a recording, and its tracks: from the pictures, or as they were stored, in metres by
/// the views of `header`. real_time: as slowly as they were recorded, and told second by second.
acquisition::Streams replayed_streams(const recorded::RecordingReader& file,
                                      const recorded::RecordingHeader& header, bool pictures, bool real_time,
                                      std::vector<std::string>& notes);

/// Of a recording that was never finished: with stored tracks, whose times are found from the frames' stamps.
acquisition::Streams stored_streams(const recorded::RecordingReader& file, std::vector<std::string>& notes);

}  // namespace shaker::recording

#pragma once
// The streams of a recording, as an acquisition gathers them.
#include <string>
#include <vector>

#include "daemon/acquisition/streams.hpp"
#include "drivers/recorded/recording_file.hpp"

namespace shaker::recording {

/// Why the tracks of a recording cannot be computed from its pictures; empty when they can, also when its
/// cameras give positions instead of pictures.
std::string why_not_from_pictures(const recorded::RecordingReader& file);

/// The raw streams of a recording and its tracks: computed from the pictures or read from the file, in metres
/// by the views of `header`.
acquisition::Streams replayed_streams(const recorded::RecordingReader& file,
                                      const recorded::RecordingHeader& header, bool pictures,
                                      std::vector<std::string>& notes);

/// The streams of an unfinished recording: stored tracks with times computed from the stamps of the frames.
acquisition::Streams stored_streams(const recorded::RecordingReader& file, std::vector<std::string>& notes);

}  // namespace shaker::recording

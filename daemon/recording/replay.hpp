#pragma once
// The streams of a recording, as an acquisition gathers them, and settings of a replay that differ from those
// of the recording: "key=value".
#include <string>
#include <vector>

#include "daemon/acquisition/streams.hpp"
#include "drivers/recorded/recording_file.hpp"

namespace shaker::recording {

/// Why the tracks of a recording cannot be computed from its pictures; empty when they can, also when its
/// cameras give positions instead of pictures.
std::string why_not_from_pictures(const recorded::RecordingReader& file);
/// The same, or that the file is of a version whose targets were followed otherwise: its tracks are used.
std::string why_not_followed_again(const recorded::RecordingReader& file);

/// The raw streams of a recording and its tracks: computed from the pictures or read from the file, in metres
/// by the views of `header`.
acquisition::Streams replayed_streams(const recorded::RecordingReader& file,
                                      const recorded::RecordingHeader& header, bool pictures,
                                      std::vector<std::string>& notes);

/// The streams of an unfinished recording: stored tracks with times computed from the stamps of the frames.
acquisition::Streams stored_streams(const recorded::RecordingReader& file, std::vector<std::string>& notes);

/// Settings with which a replay is reduced.
struct ReplayOverrides {
    recorded::RecordingHeader header;
    double from_s = 0, to_s = 0;  // part of master time; NaN: the recording has no results
    bool changed = false;         // at least one setting differs from the recording
};

/// The recording's settings, changed by `set`. InputError for a value that is not allowed and for an unknown
/// key; the latter lists all keys.
ReplayOverrides replay_settings(const recorded::RecordingReader& file, const std::vector<std::string>& set);

}  // namespace shaker::recording

#pragma once
// Settings of a replay that differ from those of the recording: "key=value".
#include <string>
#include <vector>

#include "drivers/recorded/recording_file.hpp"

namespace shaker::recording {

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

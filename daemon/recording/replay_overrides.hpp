#pragma once
// Other settings for a replay than those a recording was made with: "key=value".
#include <string>
#include <vector>

#include "drivers/recorded/recording_file.hpp"

namespace shaker::recording {

/// What a replay is reduced with.
struct ReplayOverrides {
    recorded::RecordingHeader header;
    double from_s = 0, to_s = 0;  // part of master time; NaN: nothing had been reduced
    bool changed = false;         // anything but what was recorded
};

/// The recording's own, and over them what `set` says. InputError for a key or a value that is not allowed;
/// for an unknown key it lists all there are.
ReplayOverrides replay_settings(const recorded::RecordingReader& file, const std::vector<std::string>& set);

}  // namespace shaker::recording

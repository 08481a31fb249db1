#pragma once
// Other settings for a replay than those a recording was made with: "key=value".
#include <string>
#include <vector>

#include "drivers/replay/session_file.hpp"

namespace shaker {

/// What a replay is reduced with.
struct ReplaySettings {
    SessionHeader header;
    double from_s = 0, to_s = 0;  // part of master time; NaN: nothing had been reduced
    bool changed = false;         // anything but what was recorded
};

/// The recording's own, and over them what `set` says. InputError for a key or a value that is not allowed;
/// for an unknown key it lists all there are.
ReplaySettings replay_settings(const SessionReader& file, const std::vector<std::string>& set);

}  // namespace shaker

#pragma once
// How far tracks computed from the pictures lie from those that were recorded.
#include <string>
#include <vector>

#include "daemon/acquisition/streams.hpp"
#include "drivers/recorded/recording_file.hpp"

namespace shaker::recording {

/// One sentence for each target whose places differ from the recorded ones.
std::vector<std::string> track_changes(const recorded::RecordingReader& file,
                                       const acquisition::Streams& now);

}  // namespace shaker::recording

#pragma once
// Internal state of a RecordingReader, for the classes that read streams from the same file.
#include "drivers/recorded/h5/h5.hpp"
#include "drivers/recorded/recording_file.hpp"

namespace shaker::recorded {

struct RecordingReader::Opened {
    std::filesystem::path path;
    h5::Handle file, entry;
    RecordingHeader header;
};

}  // namespace shaker::recorded

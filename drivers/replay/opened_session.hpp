#pragma once
// The inside of a SessionReader, for what reads streams out of the same file.
#include "drivers/replay/h5.hpp"
#include "drivers/replay/session_file.hpp"

namespace shaker {

struct SessionReader::Opened {
    std::filesystem::path path;
    h5::Handle file, entry;
    SessionHeader header;
};

}  // namespace shaker

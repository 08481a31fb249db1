#pragma once
// What is left of a camera's pictures after a crash, and the end of a recording of them.
#include <cstdint>
#include <string>
#include <vector>

#include "drivers/replay/opened_segment.hpp"

namespace shaker {

struct BadPicture {
    std::uint64_t number;  // from 1
    std::filesystem::path file;
    FrameFault fault;
};

struct FrameCheck {
    std::uint64_t whole = 0;  // pictures that are as they were stored
    std::uint64_t last = 0;   // the highest number among them; 0: none
    /// In order of their numbers. Those up to `last` were lost or changed; those behind it were on their way
    /// when the writer ended.
    std::vector<BadPicture> bad;
    std::vector<std::string>
        damaged;  // files that cannot be read, and the pictures that are missing with them
};

/// Reads every picture. InputError when there is nothing that can be read.
FrameCheck verify_frames(const std::filesystem::path& folder, const std::string& camera);

/// Ends a recording: what is behind picture `last` is cut off, files without pictures go, the link over all
/// is written. A file is replaced by its shorter copy or stays; files that cannot be read stay. Whole
/// pictures must not be behind `last`. DeviceError when the disk fails: then it can be done again.
void end_frames(const std::filesystem::path& folder, const std::string& camera, std::uint64_t last);

/// verify_frames(), and the end behind the last whole picture. Bad ones before it stay, and are told. Once
/// more changes nothing.
FrameCheck finish_frames(const std::filesystem::path& folder, const std::string& camera);

}  // namespace shaker

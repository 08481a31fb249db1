#pragma once
// Pictures of one camera, read back from its segments: each is checked against what was stored.
#include <optional>

#include "drivers/replay/opened_segment.hpp"

namespace shaker {

class FrameReader {
public:
    /// The segments of a camera, finished or as a crash left them. InputError when there are none that can be
    /// read.
    FrameReader(const std::filesystem::path& folder, const std::string& camera);

    [[nodiscard]] FrameShape shape() const noexcept { return found_.good.front().info.shape; }
    /// Pictures up to the last one with a record, good or bad.
    [[nodiscard]] std::uint64_t count() const noexcept { return count_; }
    /// Segments that cannot be read, and why; their pictures are counted and refused.
    [[nodiscard]] const std::vector<std::string>& damaged() const noexcept { return found_.damaged; }
    /// Picture 0 to count() - 1. InputError naming file and picture when it is not as it was stored; others
    /// can be read all the same.
    FramePtr read(std::uint64_t picture);

private:
    const OpenedSegment& segment_with(std::uint64_t number);

    FoundSegments found_;
    std::uint64_t count_ = 0;
    std::optional<OpenedSegment> opened_;  // the one that was used last
};

}  // namespace shaker

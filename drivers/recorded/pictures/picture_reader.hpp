#pragma once
// PictureReader: reads the pictures of one camera from its segments and checks each one.
#include <optional>

#include "drivers/recorded/pictures/opened_segment.hpp"

namespace shaker::pictures {

class PictureReader {
public:
    /// Opens the segments of a camera, finished or left by a crash. InputError when none is readable.
    PictureReader(const std::filesystem::path& folder, const std::string& camera);

    [[nodiscard]] PictureShape shape() const noexcept { return found_.good.front().info.shape; }
    /// Number of pictures up to the last one with a record, good or bad.
    [[nodiscard]] std::uint64_t count() const noexcept { return count_; }
    /// Unreadable segments with the reason; their pictures are counted, and read() refuses them.
    [[nodiscard]] const std::vector<std::string>& damaged() const noexcept { return found_.damaged; }
    /// Picture 0 to count() - 1. InputError with file and picture when it is damaged; other pictures can
    /// still be read.
    FramePtr read(std::uint64_t picture);

private:
    const OpenedSegment& segment_with(std::uint64_t number);

    FoundSegments found_;
    std::uint64_t count_ = 0;
    std::optional<OpenedSegment> opened_;  // the last one used
};

}  // namespace shaker::pictures

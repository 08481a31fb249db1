#pragma once
// PictureReader: reads the pictures of one camera from its segments and checks each one. Contents of a
// segment are checked against the size of the file and the layout (segment.hpp) before use.
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "drivers/recorded/h5/disk_file.hpp"
#include "drivers/recorded/pictures/segment.hpp"

namespace shaker::pictures {

/// Location of the pictures of a segment. Keeps no file open: there can be thousands.
struct FoundSegment {
    std::filesystem::path file;
    PictureSegmentInfo info;
    PictureSegmentPlan plan;
};

/// Checks a file; InputError with its name and the defect.
FoundSegment find_segment(const std::filesystem::path& file, const std::string& camera);

/// All segments of a camera.
struct FoundSegments {
    std::vector<FoundSegment> good;  // in order of their numbers, without overlap, of one shape
    /// Each unreadable file with the reason; and "pictures 65 to 128 are in no readable file".
    std::vector<std::string> damaged;
};
/// InputError without a segment, or when segments contradict each other.
FoundSegments find_segments(const std::filesystem::path& folder, const std::string& camera);

/// Reads records and pixels of one segment.
class OpenedSegment {
public:
    /// InputError when the file has become shorter or is missing; DeviceError when the disk fails.
    explicit OpenedSegment(const FoundSegment& segment);
    [[nodiscard]] const FoundSegment& found() const noexcept { return found_; }
    /// One record per place.
    [[nodiscard]] const std::vector<PictureRecord>& records() const noexcept { return records_; }
    /// Number of places up to the last used one; later places were never written.
    [[nodiscard]] std::uint64_t used() const noexcept;
    /// Reads the pixels of a place; `pixels` must have room for one picture.
    void read(std::uint64_t place, std::span<std::byte> pixels) const;
    /// Drops the file's pages from the page cache.
    void forget() const { file_.forget(); }

private:
    FoundSegment found_;
    h5::DiskFile file_;
    std::vector<PictureRecord> records_;
};

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

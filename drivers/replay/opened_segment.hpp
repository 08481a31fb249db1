#pragma once
// A segment of pictures as it is found on a disk: nothing in it is trusted before it was compared with the
// size of the file and with what frame_layout.hpp says.
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "drivers/replay/disk_file.hpp"
#include "drivers/replay/frame_layout.hpp"

namespace shaker {

/// Where the pictures of a segment are. Holds no file open: there can be thousands.
struct FoundSegment {
    std::filesystem::path file;
    FrameSegmentInfo info;
    FrameSegmentPlan plan;
};

/// Looks into a file; InputError naming it and what is not as it must be.
FoundSegment find_segment(const std::filesystem::path& file, const std::string& camera);

/// All of a camera's segments.
struct FoundSegments {
    std::vector<FoundSegment> good;  // in order of their numbers, which do not overlap, of one shape
    /// Each file that cannot be read, and why; and "pictures 65 to 128 are in no file that can be read".
    std::vector<std::string> damaged;
};
/// InputError when there is none, or when what is there contradicts itself.
FoundSegments find_segments(const std::filesystem::path& folder, const std::string& camera);

/// Reads records and pixels of one segment.
class OpenedSegment {
public:
    /// InputError when the file has become shorter or is gone; DeviceError when the disk fails.
    explicit OpenedSegment(const FoundSegment& segment);
    [[nodiscard]] const FoundSegment& found() const noexcept { return found_; }
    /// One for each place.
    [[nodiscard]] const std::vector<FrameRecord>& records() const noexcept { return records_; }
    /// Places up to the last that is used; those after it were never written.
    [[nodiscard]] std::uint64_t used() const noexcept;
    /// The pixels at a place into memory for one picture.
    void read(std::uint64_t place, std::span<std::byte> pixels) const;
    /// Its part of the page cache is not needed any more.
    void forget() const { file_.forget(); }

private:
    FoundSegment found_;
    DiskFile file_;
    std::vector<FrameRecord> records_;
};

}  // namespace shaker

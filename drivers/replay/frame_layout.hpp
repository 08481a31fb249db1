#pragma once
// A segment of one camera's pictures as a file: plain HDF5, complete before the first picture is in it.
//
//   /         camera, width, height, bytes_per_pixel, first_number (of the first place, from 1)
//   /frames   [places, height, width] u8 or u16, contiguous, on a page of the file
//   /index    [places] FrameRecord, contiguous; zeros: the place is not used
//
// <folder>/<camera>-0000.h5, -0001.h5, ... follow each other; <folder>/<camera>.h5 shows them as one.
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "drivers/replay/frame_record.hpp"

namespace shaker {

struct FrameSegmentInfo {
    std::string camera;
    FrameShape shape;
    std::uint64_t first = 1;   // number of the first place
    std::uint64_t places = 0;  // pictures it has room for
    [[nodiscard]] std::uint64_t end() const noexcept { return first + places; }
};

/// Where things lie in a segment, bytes from its begin; 0 when there are no places.
struct FrameSegmentPlan {
    std::uint64_t index_at = 0;
    std::uint64_t frames_at = 0;
};

/// A new segment: what its file begins with, and its length with whole pages for the pictures. What is not in
/// `head` is zero.
struct FrameSegmentImage {
    FrameSegmentPlan plan;
    std::vector<std::byte> head;
    std::uint64_t bytes = 0;
};
FrameSegmentImage image_of(const FrameSegmentInfo& info);

std::filesystem::path segment_file(const std::filesystem::path& folder, const std::string& camera,
                                   std::uint64_t segment);
/// The camera's segments in a folder, in order of their number; empty when there is no such folder.
std::vector<std::filesystem::path> segment_files(const std::filesystem::path& folder,
                                                 const std::string& camera);
/// What a crash left of files of this camera while they were made.
std::vector<std::filesystem::path> unfinished_files(const std::filesystem::path& folder,
                                                    const std::string& camera);
/// The file that shows all segments as one.
std::filesystem::path link_file(const std::filesystem::path& folder, const std::string& camera);

}  // namespace shaker

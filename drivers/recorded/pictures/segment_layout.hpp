#pragma once
// Layout of one segment of a camera's pictures: plain HDF5, complete before the first picture is written.
//
//   /         camera, width, height, bytes_per_pixel, first_number (of the first place, from 1)
//   /frames   [places, height, width] u8 or u16, contiguous, on a page of the file
//   /index    [places] PictureRecord, contiguous; zeros: the place is not used
//
// <folder>/<camera>-0000.h5, -0001.h5, ... follow each other; <folder>/<camera>.h5 shows them as one.
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "drivers/recorded/pictures/picture_record.hpp"

namespace shaker::pictures {

struct PictureSegmentInfo {
    std::string camera;
    PictureShape shape;
    std::uint64_t first = 1;   // number of the first picture
    std::uint64_t places = 0;  // number of pictures it has space for
    [[nodiscard]] std::uint64_t end() const noexcept { return first + places; }
};

/// Offsets in a segment, bytes from its start; 0 when there are no places.
struct PictureSegmentPlan {
    std::uint64_t index_at = 0;
    std::uint64_t frames_at = 0;
};

/// A new segment: first bytes of its file, and its length including whole pages for the pictures. Bytes
/// outside `head` are zero.
struct PictureSegmentImage {
    PictureSegmentPlan plan;
    std::vector<std::byte> head;
    std::uint64_t bytes = 0;
};
PictureSegmentImage image_of(const PictureSegmentInfo& info);

std::filesystem::path segment_file(const std::filesystem::path& folder, const std::string& camera,
                                   std::uint64_t segment);
/// The camera's segments in a folder, in order of their number; empty when the folder does not exist.
std::vector<std::filesystem::path> segment_files(const std::filesystem::path& folder,
                                                 const std::string& camera);
/// Temporary files of this camera left by a crash.
std::vector<std::filesystem::path> unfinished_files(const std::filesystem::path& folder,
                                                    const std::string& camera);
/// The file that shows all segments as one.
std::filesystem::path link_file(const std::filesystem::path& folder, const std::string& camera);

}  // namespace shaker::pictures

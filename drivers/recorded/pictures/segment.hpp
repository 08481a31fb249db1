#pragma once
// Layout of one segment of a camera's pictures: plain HDF5, complete before the first picture is written.
//
//   /         camera, width, height, bytes_per_pixel, first_number (of the first place, from 1)
//   /frames   [places, height, width] u8 or u16, contiguous, on a page of the file
//   /index    [places] PictureRecord, contiguous; zeros: the place is not used
//
// <folder>/<camera>-0000.h5, -0001.h5, ... follow each other; <folder>/<camera>.h5 shows them as one.
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "drivers/recorded/h5/disk_file.hpp"
#include "drivers/recorded/h5/h5.hpp"
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

/// Types of a pixel and of a PictureRecord in a file.
hid_t pixel_type(const PictureShape& shape);
h5::Handle record_type();

/// One segment of pictures while it is written. The file is complete and valid from the start; pictures are
/// written in blocks of 8 past the page cache, followed by their records.
class PictureSegment {
public:
    static constexpr std::size_t block = 8;  // pictures per write
    /// Pictures per write when more are waiting: each write may also wait for a busy processor.
    static constexpr std::size_t large_block = 64;

    /// Creates `file` with space on the disk for all pictures, none of them used. When this returns, the file
    /// is on the disk under this name; on an error it does not exist. DeviceError, with the required and
    /// the free space, when the disk is full; InputError when the file exists.
    PictureSegment(const std::filesystem::path& file, const PictureSegmentInfo& info);

    [[nodiscard]] const std::filesystem::path& file() const noexcept { return file_.path(); }
    [[nodiscard]] const PictureSegmentInfo& info() const noexcept { return info_; }
    [[nodiscard]] bool full() const noexcept { return taken_ == info_.places; }
    /// Number of pictures whose pixels and records were passed to the system: a crash of the program does not
    /// lose them.
    [[nodiscard]] std::uint64_t written() const noexcept { return written_; }
    /// False if pictures go through the page cache.
    [[nodiscard]] bool direct() const noexcept { return file_.direct(); }

    /// Adds the next picture; requires !full(). Writes when a block is complete (a large one if `more`
    /// pictures are ready to follow), or for the last picture.
    void add(const PictureRecord& record, std::span<const std::byte> pixels, bool more = false);
    /// Writes the waiting pictures, however few.
    void write();
    /// write(), then returns when all of it is on the disk.
    void sync();
    /// Takes over the buffer of a full segment.
    void follow(PictureSegment& full) noexcept { pages_.swap(full.pages_); }
    /// Renames the file, replacing `to`.
    void replace(const std::filesystem::path& to) { file_.rename(to, h5::DiskFile::Existing::replace); }

private:
    struct alignas(h5::page_bytes) Page {
        std::array<std::byte, h5::page_bytes> bytes{};
    };
    PictureSegment(const std::filesystem::path& file, const PictureSegmentInfo& info,
                   const PictureSegmentImage& image);

    PictureSegmentInfo info_;
    PictureSegmentPlan plan_;
    h5::DiskFile file_;
    std::vector<Page> pages_;   // waiting pictures, from page `begin_` of the file on; allocated as needed
    std::uint64_t begin_ = 0;   // page of the file
    std::size_t gathered_ = 0;  // bytes in use in pages_
    std::vector<PictureRecord> records_;  // of pictures not written yet
    std::uint64_t taken_ = 0, written_ = 0;
};

}  // namespace shaker::pictures

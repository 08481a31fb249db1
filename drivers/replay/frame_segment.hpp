#pragma once
// One segment of pictures while it is written: a file that is complete and valid from its begin, into which
// pictures go in blocks of 8 past the page cache, and then their records.
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "drivers/replay/disk_file.hpp"
#include "drivers/replay/frame_layout.hpp"

namespace shaker {

class FrameSegment {
public:
    static constexpr std::size_t block = 8;  // pictures that are written together
    /// And when more wait: each write costs the wait for a processor that others use, too.
    static constexpr std::size_t large_block = 64;

    /// Makes `file` with room on the disk for all pictures, none of them used; it is under this name, on the
    /// disk, when this returns, or else not at all. DeviceError, with what is needed and free when there is
    /// no room.
    FrameSegment(const std::filesystem::path& file, const FrameSegmentInfo& info);

    [[nodiscard]] const std::filesystem::path& file() const noexcept { return file_.path(); }
    [[nodiscard]] const FrameSegmentInfo& info() const noexcept { return info_; }
    [[nodiscard]] bool full() const noexcept { return taken_ == info_.places; }
    /// Pictures whose pixels and records are with the system: a crash of the program does not lose them.
    [[nodiscard]] std::uint64_t written() const noexcept { return written_; }
    /// False where pictures go through the page cache.
    [[nodiscard]] bool direct() const noexcept { return file_.direct(); }

    /// Takes the next picture as it is; not when full(). Writes when a block has gathered, or a large one
    /// when `more` are ready to follow, or when it is the last.
    void add(const FrameRecord& record, std::span<const std::byte> pixels, bool more = false);
    /// Writes what has gathered, however little.
    void write();
    /// write(), and returns when all of it is on the disk.
    void sync();
    /// Uses the memory of a segment that is full.
    void follow(FrameSegment& full) noexcept { pages_.swap(full.pages_); }
    /// Takes the place of another file.
    void rename(const std::filesystem::path& to) { file_.rename(to); }

private:
    struct alignas(page_bytes) Page {
        std::array<std::byte, page_bytes> bytes{};
    };
    FrameSegment(const std::filesystem::path& file, const FrameSegmentInfo& info,
                 const FrameSegmentImage& image);

    FrameSegmentInfo info_;
    FrameSegmentPlan plan_;
    DiskFile file_;
    std::vector<Page> pages_;           // pictures on their way, from `begin_` of the file on; as needed
    std::uint64_t begin_ = 0;           // page of the file
    std::size_t gathered_ = 0;          // bytes in pages_
    std::vector<FrameRecord> records_;  // of pictures not yet written
    std::uint64_t taken_ = 0, written_ = 0;
};

}  // namespace shaker

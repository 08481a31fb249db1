#pragma once
// PictureRecord: metadata and checksums of one picture in a segment, as stored on the disk.
#include <array>
#include <cstdint>
#include <limits>
#include <span>

#include "drivers/data.hpp"

namespace shaker::pictures {

/// Stamp of a frame without a stamp, here and in raw/<camera>/stamp of a recording.
inline constexpr std::int64_t no_stamp = std::numeric_limits<std::int64_t>::min();

struct PictureShape {
    static constexpr int most = 65535;  // px, largest width or height
    int width = 0;                      // px
    int height = 0;                     // px
    int bytes_per_pixel = 1;            // 1 or 2
    bool operator==(const PictureShape&) const = default;
    [[nodiscard]] std::size_t bytes() const noexcept {
        return static_cast<std::size_t>(width) * static_cast<std::size_t>(height) *
               static_cast<std::size_t>(bytes_per_pixel);
    }
};

/// 64 bytes, so that none crosses a disk sector; all zeros: the place is not used.
struct PictureRecord {
    std::uint64_t number = 0;  // from 1; counts this camera's stored pictures over all segments
    std::int64_t tick = 0;
    std::int64_t arrived = 0;  // ns of the host's clock
    std::int64_t stamp = 0;    // ns of the camera's clock, or no_stamp
    double mid_exposure = 0;   // s, master time; NaN: unknown
    std::uint8_t quality = 0;
    std::array<std::uint8_t, 3> padding{};
    std::uint32_t pixels_crc32c = 0;
    std::array<std::uint8_t, 12> reserved{};
    std::uint32_t record_crc32c = 0;  // of all bytes before it
    bool operator==(const PictureRecord&) const = default;
};
static_assert(sizeof(PictureRecord) == 64);

/// The record, with checksums, of the picture with this number.
PictureRecord record_of(const Frame& frame, std::uint64_t number) noexcept;

/// Defect of a place in a segment.
enum class PictureFault : std::uint8_t {
    none,
    no_record,   // never used, or lost
    bad_record,  // changed, torn while it was written, or of another picture
    bad_pixels   // changed or unreadable
};
/// Text for a fault, to follow the picture's name: "has no record".
const char* words_for(PictureFault fault) noexcept;

/// The fault visible in the record alone, for picture `number`.
PictureFault fault_of(const PictureRecord& record, std::uint64_t number) noexcept;
/// The fault visible in record and pixels.
PictureFault fault_of(const PictureRecord& record, std::uint64_t number,
                      std::span<const std::byte> pixels) noexcept;

/// The frame of an intact record, without pixels.
Frame frame_of(const PictureRecord& record, const PictureShape& shape);

}  // namespace shaker::pictures

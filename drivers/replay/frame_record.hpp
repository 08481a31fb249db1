#pragma once
// What a segment of pictures says about each of them, as it is on the disk.
#include <array>
#include <cstdint>
#include <span>

#include "drivers/data.hpp"

namespace shaker {

struct FrameShape {
    static constexpr int most = 65535;  // of either side, px
    int width = 0;                      // px
    int height = 0;                     // px
    int bytes_per_pixel = 1;            // 1 or 2
    bool operator==(const FrameShape&) const = default;
    [[nodiscard]] std::size_t bytes() const noexcept {
        return static_cast<std::size_t>(width) * static_cast<std::size_t>(height) *
               static_cast<std::size_t>(bytes_per_pixel);
    }
};

/// 64 bytes, so that none lies across two sectors of a disk; all zeros: the place is not used.
struct FrameRecord {
    std::uint64_t number = 0;  // from 1, of this camera's stored pictures over all segments
    std::int64_t tick = 0;
    std::int64_t arrived = 0;  // ns of the host's clock
    std::int64_t stamp = 0;    // ns of the camera's clock, or no_stamp
    double mid_exposure = 0;   // s, master time; NaN: not known
    std::uint8_t quality = 0;
    std::array<std::uint8_t, 3> padding{};
    std::uint32_t pixels_crc32c = 0;
    std::array<std::uint8_t, 12> reserved{};
    std::uint32_t record_crc32c = 0;  // of all before it
    bool operator==(const FrameRecord&) const = default;
};
static_assert(sizeof(FrameRecord) == 64);

/// The sealed record of a picture that is stored as the `number`-th.
FrameRecord record_of(const Frame& frame, std::uint64_t number) noexcept;

/// What is wrong with a place in a segment.
enum class FrameFault : std::uint8_t {
    none,
    no_record,   // never used, or lost
    bad_record,  // changed, or torn while it was written, or that of another picture
    bad_pixels   // not those that were stored, or not readable
};
/// Words for a fault: "its record is damaged".
const char* words_for(FrameFault fault) noexcept;

/// What the record alone tells, in the place of picture `number`.
FrameFault fault_of(const FrameRecord& record, std::uint64_t number) noexcept;
/// What record and pixels tell.
FrameFault fault_of(const FrameRecord& record, std::uint64_t number,
                    std::span<const std::byte> pixels) noexcept;

/// The picture of a whole record, without its pixels.
Frame frame_of(const FrameRecord& record, const FrameShape& shape);

}  // namespace shaker

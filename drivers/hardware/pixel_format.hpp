#pragma once
// Grey pixel formats of GenICam cameras (names and codes of the Pixel Format Naming Convention) and how the
// packed ones are taken apart.
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

namespace shaker {

enum class Packing {
    none,  // one or two bytes a pixel, least significant first
    gige,  // "Packed": two pixels in three bytes, as GigE Vision 1 laid them out
    pfnc,  // "p": pixels follow each other without gaps, least significant bit first
};

struct PixelFormat {
    std::string_view name;
    std::uint32_t code = 0;
    int bits = 8;  // that carry light; full scale is 2^bits - 1
    Packing packing = Packing::none;

    /// Of a frame in memory: formats of more than 8 bits have 2 bytes a pixel, native, not scaled.
    [[nodiscard]] int bytes_per_pixel() const noexcept { return bits > 8 ? 2 : 1; }
    [[nodiscard]] int full_scale() const noexcept { return (1 << bits) - 1; }
    /// Bytes that a picture of so many pixels takes on the wire.
    [[nodiscard]] std::size_t wire_bytes(std::size_t pixels) const noexcept;
};

/// All that are understood, fewest bits first.
std::span<const PixelFormat> pixel_formats() noexcept;
/// Null when it is not one of them.
const PixelFormat* find_pixel_format(std::string_view name) noexcept;

/// Takes a packed picture apart, as many pixels as `out` holds (2 bytes each). `wire` has at least
/// wire_bytes() of them. Real-time.
void unpack_pixels(const PixelFormat& format, std::span<const std::byte> wire,
                   std::span<std::byte> out) noexcept;

}  // namespace shaker

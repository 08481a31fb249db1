#pragma once
// Grey pixel formats of GenICam cameras (names and codes of the Pixel Format Naming Convention) and unpacking
// of the packed ones.
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

namespace shaker::genicam {

enum class Packing {
    none,  // one or two bytes a pixel, least significant first
    gige,  // "Packed": two pixels in three bytes, as in GigE Vision 1
    pfnc,  // "p": pixels follow each other without gaps, least significant bit first
};

struct PixelFormat {
    std::string_view name;
    std::uint32_t code = 0;
    int bits = 8;  // significant bits; full scale is 2^bits - 1
    Packing packing = Packing::none;

    /// Bytes per pixel of a frame in memory: 2 for formats of more than 8 bits, native endian, not scaled.
    [[nodiscard]] int bytes_per_pixel() const noexcept { return bits > 8 ? 2 : 1; }
    [[nodiscard]] int full_scale() const noexcept { return (1 << bits) - 1; }
    /// Bytes of a picture of `pixels` pixels in transfer.
    [[nodiscard]] std::size_t wire_bytes(std::size_t pixels) const noexcept;
};

/// All supported formats, fewest bits first.
std::span<const PixelFormat> pixel_formats() noexcept;
/// Null when the format is not supported.
const PixelFormat* find_pixel_format(std::string_view name) noexcept;

/// Unpacks as many pixels as `out` holds (2 bytes each). `wire` must have at least wire_bytes() bytes for
/// them. Real-time.
void unpack_pixels(const PixelFormat& format, std::span<const std::byte> wire,
                   std::span<std::byte> out) noexcept;

}  // namespace shaker::genicam

#pragma once
// Settings of a GenICam camera (GigE Vision or USB3 Vision) in a rig file, and its grey pixel formats (names
// and codes of the Pixel Format Naming Convention) with unpacking of the packed ones.
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "drivers/settings_table.hpp"

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

/// Source of the exposure trigger.
enum class CameraTrigger {
    dac,       // pulses of the DAC's second channel on the camera's trigger line
    software,  // one command per period from the driver; for set-up only, its times have jitter
    free,      // the camera's own clock
};

struct GenicamSettings {
    std::string id;                  // as listed by `shakerd devices`, serial number, or address
    std::array<int, 4> region_px{};  // x, y, width, height on the sensor; width 0: the whole sensor
    double exposure_s = 0.001;
    double frame_rate_hz = 100;  // of the trigger, or of the camera's clock when it runs free
    std::string pixel_format = "Mono8";
    CameraTrigger trigger = CameraTrigger::dac;
    std::string trigger_source = "Line0";
    int packet_bytes = 0;        // in transfer; 0: the largest that gets through
    bool ptp = false;            // synchronise its clock to the network's
    bool chunks = false;         // frame id and time stamp inside the picture
    std::optional<double> gain;  // in the camera's unit, usually dB; empty: unchanged
    double give_up_s = 30;       // s, time to search for a camera that disappeared
};

/// Reads and checks these keys: id (required), region_px, exposure_s, frame_rate_hz, pixel_format, trigger
/// ("dac", "software", "free"), trigger_source, packet_bytes, ptp, chunks, gain, give_up_s. Throws
/// InputError.
GenicamSettings read_genicam_settings(SettingsTable& table);

}  // namespace shaker::genicam

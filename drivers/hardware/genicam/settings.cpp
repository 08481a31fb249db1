#include "drivers/hardware/genicam/settings.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

namespace shaker::genicam {

namespace {

static_assert(std::endian::native == std::endian::little, "cameras send words least significant byte first");

constexpr std::array<PixelFormat, 8> known{{
    {"Mono8", 0x01080001, 8, Packing::none},
    {"Mono10", 0x01100003, 10, Packing::none},
    {"Mono10Packed", 0x010c0004, 10, Packing::gige},
    {"Mono10p", 0x010a0046, 10, Packing::pfnc},
    {"Mono12", 0x01100005, 12, Packing::none},
    {"Mono12Packed", 0x010c0006, 12, Packing::gige},
    {"Mono12p", 0x010c0047, 12, Packing::pfnc},
    {"Mono16", 0x01100007, 16, Packing::none},
}};

void put(std::span<std::byte> out, std::size_t pixel, unsigned code) noexcept {
    const auto word = static_cast<std::uint16_t>(code);
    std::memcpy(&out[2 * pixel], &word, sizeof word);
}

unsigned at(std::span<const std::byte> wire, std::size_t i) noexcept {
    return i < wire.size() ? std::to_integer<unsigned>(wire[i]) : 0;
}

/// Byte 0: upper 8 bits of the first pixel; byte 2: those of the second; byte 1: lower bits of both, the
/// first pixel's from bit 0, the second's from bit 4.
void unpack_gige(unsigned low_bits, std::span<const std::byte> wire, std::span<std::byte> out) noexcept {
    const unsigned mask = (1u << low_bits) - 1;
    const std::size_t pixels = out.size() / 2;
    for (std::size_t i = 0; i < pixels; ++i) {
        const std::size_t group = i / 2 * 3;
        const unsigned low = at(wire, group + 1) >> (i % 2 == 0 ? 0 : 4);
        put(out, i, at(wire, group + (i % 2 == 0 ? 0 : 2)) << low_bits | (low & mask));
    }
}

void unpack_stream(unsigned bits, std::span<const std::byte> wire, std::span<std::byte> out) noexcept {
    const unsigned mask = (1u << bits) - 1;
    const std::size_t pixels = out.size() / 2;
    unsigned held = 0, have = 0;
    std::size_t next = 0;
    for (std::size_t i = 0; i < pixels; ++i) {
        for (; have < bits; have += 8) held |= at(wire, next++) << have;
        put(out, i, held & mask);
        held >>= bits;
        have -= bits;
    }
}

std::array<int, 4> read_region(SettingsTable& table) {
    std::array<int, 4> region{};
    if (!table.has("region_px")) return region;
    const std::vector<double> numbers = table.numbers("region_px", region.size());
    for (std::size_t i = 0; i < region.size(); ++i) {
        const double least = i < 2 ? 0 : 1, most = 65536;
        if (numbers[i] != std::floor(numbers[i]) || numbers[i] < least || numbers[i] > most)
            table.fail("region_px",
                       "expected four whole numbers: x and y at least 0, width and height at least 1");
        region[i] = static_cast<int>(numbers[i]);
    }
    return region;
}

std::string read_pixel_format(SettingsTable& table, const std::string& otherwise) {
    std::string name = table.text("pixel_format", otherwise);
    if (find_pixel_format(name) != nullptr) return name;
    std::string allowed;
    for (const PixelFormat& format : pixel_formats())
        allowed += (allowed.empty() ? "\"" : ", \"") + std::string{format.name} + "\"";
    table.fail("pixel_format", "\"" + name + "\" is not supported; expected one of " + allowed);
}

}  // namespace

std::size_t PixelFormat::wire_bytes(std::size_t pixels) const noexcept {
    const auto bits_on_wire = static_cast<std::size_t>((code >> 16) & 0xff);
    return (pixels * bits_on_wire + 7) / 8;
}

std::span<const PixelFormat> pixel_formats() noexcept { return known; }

const PixelFormat* find_pixel_format(std::string_view name) noexcept {
    const auto* const found = std::ranges::find(known, name, &PixelFormat::name);
    return found != known.end() ? found : nullptr;
}

void unpack_pixels(const PixelFormat& format, std::span<const std::byte> wire,
                   std::span<std::byte> out) noexcept {
    const auto bits = static_cast<unsigned>(format.bits);
    switch (format.packing) {
        case Packing::none:
            std::memcpy(out.data(), wire.data(), std::min(out.size(), wire.size()));
            break;
        case Packing::gige:
            unpack_gige(bits - 8, wire, out);
            break;
        case Packing::pfnc:
            unpack_stream(bits, wire, out);
            break;
    }
}

GenicamSettings read_genicam_settings(SettingsTable& table) {
    GenicamSettings s;
    s.id = table.text("id");
    s.region_px = read_region(table);
    s.exposure_s = table.number("exposure_s", {1e-6, 10}, s.exposure_s);
    s.frame_rate_hz = table.number("frame_rate_hz", {0.1, 100000}, s.frame_rate_hz);
    if (s.exposure_s * s.frame_rate_hz > 1)
        table.fail("exposure_s",
                   "must be at most the time between frames, " + to_text(1 / s.frame_rate_hz) + " s");
    s.pixel_format = read_pixel_format(table, s.pixel_format);
    s.trigger = static_cast<CameraTrigger>(table.choice("trigger", {"dac", "software", "free"}, 0));
    s.trigger_source = table.text("trigger_source", s.trigger_source);
    s.packet_bytes = table.integer("packet_bytes", 0, 65000, s.packet_bytes);
    s.ptp = table.flag("ptp", s.ptp);
    s.chunks = table.flag("chunks", s.chunks);
    if (table.has("gain")) s.gain = table.number("gain", {-100, 100});
    s.give_up_s = table.number("give_up_s", {0, 86400}, s.give_up_s);
    return s;
}

}  // namespace shaker::genicam

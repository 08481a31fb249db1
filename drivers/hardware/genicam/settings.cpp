#include "drivers/hardware/genicam/settings.hpp"

#include <cmath>

namespace shaker::genicam {
namespace {

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
    std::string known;
    for (const PixelFormat& format : pixel_formats())
        known += (known.empty() ? "\"" : ", \"") + std::string{format.name} + "\"";
    table.fail("pixel_format", "\"" + name + "\" is not supported; expected one of " + known);
}

}  // namespace

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

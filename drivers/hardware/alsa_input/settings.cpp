#include "drivers/hardware/alsa_input/settings.hpp"

#include <algorithm>
#include <cmath>

#include "drivers/data.hpp"
#include "drivers/errors.hpp"
#include "drivers/view_settings.hpp"

namespace shaker::alsa_input {

namespace {

constexpr double usual_rate_hz = 4000, least_rate_hz = 1000;  // of the sensor
constexpr double block_s = 0.008;

std::vector<int> channels_at(SettingsTable& table) {
    if (!table.has("channels")) return {1};
    constexpr std::size_t most_axes = 3;
    std::vector<int> channels;
    for (const double n : table.quantities("channels", Dimension::ratio, {1, 32})) {
        if (n != std::floor(n))
            table.fail("channels", shaker::to_text(n) + " is not a whole number, 1 to 32");
        channels.push_back(static_cast<int>(n));
    }
    if (channels.size() > most_axes)
        table.fail("channels", "has " + std::to_string(channels.size()) +
                                   " channels; allowed are 1 to 3, one for each axis");
    for (std::size_t i = 0; i < channels.size(); ++i)
        if (std::find(channels.begin(), channels.begin() + static_cast<std::ptrdiff_t>(i), channels[i]) !=
            channels.begin() + static_cast<std::ptrdiff_t>(i))
            table.fail("channels", "channel " + std::to_string(channels[i]) + " is given twice");
    return channels;
}

std::optional<double> sensitivity_at(SettingsTable& table) {
    constexpr const char *per_g = "sensitivity_mv_per_g", *per_mps2 = "sensitivity_mv_per_mps2";
    if (table.has(per_g) && table.has(per_mps2))
        table.fail(per_g, "sensitivity_mv_per_mps2 is given, too; use one of them");
    if (table.has(per_g)) return table.number(per_g, {1e-3, 1e5}) / standard_gravity;
    if (table.has(per_mps2)) return table.number(per_mps2, {1e-4, 1e4});
    return {};
}

}  // namespace

int InputSettings::block_samples() const noexcept {
    return std::clamp(static_cast<int>(block_s * sensor_rate_hz()), 1, AccelBlock::capacity);
}

double InputSettings::full_scale_mps2(const std::optional<UsbSensor>& usb, std::size_t axis) const {
    const auto missing = [&](const char* key) {
        return DeviceError{
            "ALSA input " + pcm + ": `" + key + "` is required in [accelerometer]: " +
            (usb ? "the USB name of this card states volts" : "the name of this card states no sensitivity")};
    };
    const auto first = static_cast<std::size_t>(std::clamp(channels.at(axis), 1, 2) - 1);
    if (!mv_per_mps2 && usb && !usb->volts) return usb->full_scale[first];
    if (!mv_per_mps2) throw missing("sensitivity_mv_per_g");
    if (!full_scale_V && !(usb && usb->volts)) throw missing("full_scale_V");
    const double volts = full_scale_V ? *full_scale_V : usb->full_scale[first];
    return volts / (1e-3 * *mv_per_mps2 * conditioner_gain);
}

InputSettings read_input_settings(SettingsTable& table) {
    InputSettings s;
    s.pcm = table.text("pcm");
    if (const std::string file = table.text("alsa_config", ""); !file.empty())
        s.alsa_config = table.folder() / file;
    s.rate_hz = table.integer("rate_hz", 8000, 768000, s.rate_hz);
    s.format = static_cast<alsa::SampleFormat>(table.choice("format", alsa::sample_formats, 0));
    s.period_frames = table.integer("period_frames", 16, 65536, s.rate_hz / 500);
    s.buffer_frames = table.integer("buffer_frames", 64, 1 << 20, s.rate_hz / 5 * 2);
    s.channels = channels_at(table);
    if (table.has("full_scale_V")) s.full_scale_V = table.number("full_scale_V", {1e-3, 1e3});
    s.mv_per_mps2 = sensitivity_at(table);
    s.conditioner_gain = table.number("conditioner_gain", {1e-3, 1e4}, s.conditioner_gain);
    if (table.has("range_mps2")) s.range_mps2 = table.number("range_mps2", {1e-6, 1e6});
    const int most = static_cast<int>(s.rate_hz / least_rate_hz);
    s.reduce = table.integer("reduce", 1, most, std::max(1, static_cast<int>(s.rate_hz / usual_rate_hz)));
    s.gravity = table.flag("gravity", s.gravity);
    s.response = read_response(table, s.gravity);
    s.dac_clock = table.choice("clock", {"own", "dac"}, 0) == 1;
    s.shaker_axis = read_shaker_axis(table, s.channels.size());
    s.clock_uncertainty_s = table.number("clock_uncertainty_s", {0, 3600}, s.clock_uncertainty_s);
    s.give_up_s = table.number("give_up_s", {0.1, 3600}, s.give_up_s);
    return s;
}

}  // namespace shaker::alsa_input

#include "drivers/hardware/alsa/settings.hpp"

#include <algorithm>
#include <cmath>

namespace shaker::alsa {

std::string_view to_text(SampleFormat format) noexcept {
    return sample_formats.at(static_cast<std::size_t>(format));
}

int AlsaSettings::ramp_frames() const noexcept {
    return static_cast<int>(std::lround(ramp_s * static_cast<double>(rate_hz)));
}

int AlsaSettings::channels() const noexcept {
    return std::max(
        {2, drive_channel, second_channel == SecondChannel::off ? 0 : trigger_channel, enable_channel});
}

namespace {

constexpr int most_channels = 64;

void read_channels(SettingsTable& table, AlsaSettings& s) {
    s.drive_channel = table.integer("drive_channel", 1, most_channels, s.drive_channel);
    s.second_channel =
        static_cast<SecondChannel>(table.choice("second_channel", {"trigger", "tone", "off"}, 0));
    if (s.second_channel == SecondChannel::off && table.has("trigger_channel"))
        table.fail("trigger_channel", "this key needs second_channel = \"trigger\" or \"tone\"");
    if (!table.has("trigger_channel") && s.drive_channel == 2) s.trigger_channel = 1;
    s.trigger_channel = table.integer("trigger_channel", 1, most_channels, s.trigger_channel);
    if (s.trigger_channel == s.drive_channel)
        table.fail("trigger_channel",
                   std::to_string(s.trigger_channel) + " is the drive's channel, too: must be another one");
}

void read_pulses(SettingsTable& table, AlsaSettings& s) {
    s.pulse_s = table.number("pulse_s", {1e-6, 0.1}, s.pulse_s);
    if (!table.has("pulse_hz")) return;
    if (s.second_channel != SecondChannel::trigger)
        table.fail("pulse_hz", "this key needs second_channel = \"trigger\"");
    s.pulse_hz = table.number("pulse_hz", {0.1, std::min(0.5 / s.pulse_s, 0.25 * s.rate_hz)});
}

void read_enable(SettingsTable& table, AlsaSettings& s) {
    for (const char* key : {"enable_level", "enable_hz", "enable_before_s"})
        if (table.has(key) && !table.has("enable_channel"))
            table.fail(key, "this key needs enable_channel, the channel of the enable tone");
    if (!table.has("enable_channel")) return;
    s.enable_channel = table.integer("enable_channel", 1, most_channels, 0);
    if (s.enable_channel == s.drive_channel ||
        (s.second_channel != SecondChannel::off && s.enable_channel == s.trigger_channel))
        table.fail("enable_channel", std::to_string(s.enable_channel) + " is not spare: channel " +
                                         std::to_string(s.drive_channel) + " is the drive, channel " +
                                         std::to_string(s.trigger_channel) +
                                         " is second_channel; must be another one, 1 to " +
                                         std::to_string(most_channels));
    s.enable_level = table.number("enable_level", {0.01, 1}, s.enable_level);
    s.enable_hz = table.number("enable_hz", {100, 0.45 * s.rate_hz}, s.enable_hz);
    s.enable_before_s = table.number("enable_before_s", {0.01, 5}, s.enable_before_s);
}

}  // namespace

AlsaSettings read_alsa_settings(SettingsTable& table) {
    AlsaSettings s;
    s.pcm = table.text("pcm");
    if (const std::string file = table.text("alsa_config", ""); !file.empty())
        s.alsa_config = table.folder() / file;
    s.rate_hz = table.integer("rate_hz", 8000, 768000, s.rate_hz);
    s.format = static_cast<SampleFormat>(table.choice("format", sample_formats, 0));
    s.period_frames = table.integer("period_frames", 16, 65536, s.period_frames);
    s.buffer_frames = table.integer("buffer_frames", 64, 1 << 20, s.buffer_frames);
    s.full_scale_V = table.number("full_scale_V", {1e-3, 100});
    read_channels(table, s);
    s.second_level = table.number("second_level", {0, 1}, s.second_level);
    read_pulses(table, s);
    s.tone_hz = table.number("tone_hz", {1, 0.45 * s.rate_hz}, s.tone_hz);
    read_enable(table, s);
    s.ramp_s = table.number("ramp_s", {0, 0.5}, s.ramp_s);
    s.dither = table.flag("dither", s.dither);
    const int least = s.ramp_frames() + 2 * s.period_frames;
    if (s.buffer_frames < least)
        table.fail("buffer_frames", std::to_string(s.buffer_frames) + " is too small: the ramp (ramp_s = " +
                                        shaker::to_text(s.ramp_s) + ": " + std::to_string(s.ramp_frames()) +
                                        " samples) and two periods require at least " +
                                        std::to_string(least));
    return s;
}

}  // namespace shaker::alsa

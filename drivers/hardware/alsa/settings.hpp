#pragma once
// Settings of a DAC behind ALSA in a rig file.
#include <array>
#include <filesystem>
#include <string>
#include <string_view>

#include "drivers/settings_table.hpp"

namespace shaker::alsa {

/// Memory layout of a sample, little endian. `s24`: 24 bits in the lower three bytes of four; `s24_3`: in
/// three bytes.
enum class SampleFormat { s32, s24, s24_3, s16 };
/// Their words in settings.
inline constexpr std::array<std::string_view, 4> sample_formats{"S32", "S24", "S24_3", "S16"};
std::string_view to_text(SampleFormat format) noexcept;

/// Signal on the channel `trigger_channel`.
enum class SecondChannel {
    trigger,  // a pulse at the start of each exposure
    tone,     // a sine, for clocks and interlocks
    off
};

struct AlsaSettings {
    std::string pcm;                    // libasound's name, e.g. "hw:CARD=Device,DEV=0"
    std::filesystem::path alsa_config;  // read after the system's configuration; empty: none
    int rate_hz = 48000;
    SampleFormat format = SampleFormat::s32;
    int period_frames = 256;
    int buffer_frames = 3328;  // the ramp and 19 ms of drive
    double full_scale_V = 1;   // V at the output for full scale
    int drive_channel = 1;     // 1-based; the channels are different ones, all others are silent
    int trigger_channel = 2;   // 1-based, of what second_channel says
    SecondChannel second_channel = SecondChannel::trigger;
    double pulse_hz = 0;      // of trigger pulses that no camera of the rig asks for; 0: none
    double second_level = 1;  // height of the pulse or amplitude of the tone, as a share of full scale
    double pulse_s = 1e-4;
    double tone_hz = 1000;
    int enable_channel = 0;   // 1-based: tone while the drive is on; 0: none
    double enable_level = 1;  // amplitude of that tone, as a share of full scale
    double enable_hz = 1000;
    double enable_before_s = 0.25;  // s, from the start of that tone to the drive
    double ramp_s = 0.05;  // s, from the drive's last value to zero when no more samples come; 0: none
    bool dither = true;

    /// The highest of the channels that are used; at least 2.
    [[nodiscard]] int channels() const noexcept;
    /// The ramp in samples.
    [[nodiscard]] int ramp_frames() const noexcept;
};

/// Keys as the members above; `alsa_config` is relative to the settings file. Only `pcm` and `full_scale_V`
/// are required. The buffer must hold the ramp and two periods. Throws InputError.
AlsaSettings read_alsa_settings(SettingsTable& table);

}  // namespace shaker::alsa

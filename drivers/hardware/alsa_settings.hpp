#pragma once
// What a rig file says about a DAC behind ALSA.
#include <filesystem>
#include <string>
#include <string_view>

#include "drivers/settings_table.hpp"

namespace shaker {

/// How a sample lies in memory, little endian. `s24` is 24 bits in the lower three bytes of four, `s24_3` in
/// three bytes.
enum class SampleFormat { s32, s24, s24_3, s16 };
/// "S32", "S24", "S24_3", "S16": as settings spell it.
std::string_view to_text(SampleFormat format) noexcept;

/// What the DAC's second channel carries.
enum class SecondChannel {
    trigger,  // a pulse from the start of each exposure
    tone,     // a sine, for clocks and interlocks
    off
};

struct AlsaSettings {
    std::string pcm;                    // as libasound names it, e.g. "hw:CARD=Device,DEV=0"
    std::filesystem::path alsa_config;  // read after the system's own; empty: none
    int rate_hz = 48000;
    SampleFormat format = SampleFormat::s32;
    int period_frames = 256;
    int buffer_frames = 4096;
    double full_scale_V = 1;  // at the output, for the largest code
    SecondChannel second_channel = SecondChannel::trigger;
    double second_level = 1;  // of the pulse, or amplitude of the tone, as a share of full scale
    double pulse_s = 1e-4;
    double tone_hz = 1000;
    double ramp_s = 0.05;  // from the drive's last value to zero when no more comes; 0: none
    bool dither = true;

    /// The ramp in samples.
    [[nodiscard]] int ramp_frames() const noexcept;
};

/// Keys as the members above, `alsa_config` relative to the settings file. Only `pcm` is required. The buffer
/// must hold the ramp and two periods. Throws InputError.
AlsaSettings read_alsa_settings(SettingsTable& table);

}  // namespace shaker

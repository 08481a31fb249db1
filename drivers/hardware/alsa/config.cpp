#include "drivers/hardware/alsa/config.hpp"

#include <alsa/asoundlib.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <thread>

#include "drivers/errors.hpp"

namespace shaker::alsa {

namespace {

using namespace std::chrono_literals;

constexpr int mode =
    SND_PCM_NONBLOCK | SND_PCM_NO_AUTO_RESAMPLE | SND_PCM_NO_AUTO_CHANNELS | SND_PCM_NO_AUTO_FORMAT;

// The device of a killed process is busy until its ramp has been played.
constexpr std::chrono::milliseconds patience = 2s, pause = 50ms;

void check(int error, const std::string& what) {
    if (error < 0) throw DeviceError{what + ": " + snd_strerror(error)};
}

struct ReleaseConfig {
    void operator()(snd_config_t* config) const noexcept { snd_config_delete(config); }
};
using Config = std::unique_ptr<snd_config_t, ReleaseConfig>;

/// The system's configuration with the file's definitions added.
Config merged(const std::filesystem::path& file) {
    snd_config_t* top = nullptr;
    check(snd_config_update_ref(&top), "ALSA's configuration");
    snd_config_t* copied = nullptr;
    const int error = snd_config_copy(&copied, top);
    snd_config_unref(top);
    check(error, "ALSA's configuration");
    Config config{copied};
    snd_input_t* input = nullptr;
    check(snd_input_stdio_open(&input, file.c_str(), "r"), file.string());
    const int parsed = snd_config_load(config.get(), input);
    snd_input_close(input);
    check(parsed, file.string());
    return config;
}

}  // namespace

AlsaHandle open_alsa_playback(const std::string& name, const std::filesystem::path& file) {
    const Config config = file.empty() ? nullptr : merged(file);
    snd_pcm_t* pcm = nullptr;
    int error = -EBUSY;
    for (auto waited = 0ms; error == -EBUSY && waited < patience; waited += pause) {
        if (waited > 0ms) std::this_thread::sleep_for(pause);
        error = config ? snd_pcm_open_lconf(&pcm, name.c_str(), SND_PCM_STREAM_PLAYBACK, mode, config.get())
                       : snd_pcm_open(&pcm, name.c_str(), SND_PCM_STREAM_PLAYBACK, mode);
    }
    check(error, "ALSA device " + name + ": cannot be opened");
    return {pcm, [](void* opened) { snd_pcm_close(static_cast<snd_pcm_t*>(opened)); }};
}

std::vector<int> possible_rates_hz(void* pcm, void* hw) {
    constexpr std::array usual{8000,  16000,  22050,  32000,  44100,  48000,  88200,
                               96000, 176400, 192000, 352800, 384000, 705600, 768000};
    std::vector<int> has;
    for (const int rate : usual)
        if (snd_pcm_hw_params_test_rate(static_cast<snd_pcm_t*>(pcm), static_cast<snd_pcm_hw_params_t*>(hw),
                                        static_cast<unsigned>(rate), 0) == 0)
            has.push_back(rate);
    return has;
}

std::vector<int> possible_channels(void* pcm, void* hw) {
    std::vector<int> has;
    for (unsigned n = 1; n <= 32; ++n)
        if (snd_pcm_hw_params_test_channels(static_cast<snd_pcm_t*>(pcm),
                                            static_cast<snd_pcm_hw_params_t*>(hw), n) == 0)
            has.push_back(static_cast<int>(n));
    return has;
}

}  // namespace shaker::alsa

#include "drivers/hardware/alsa_config.hpp"

#include <alsa/asoundlib.h>

#include "drivers/errors.hpp"

namespace shaker {

namespace {

constexpr int mode =
    SND_PCM_NONBLOCK | SND_PCM_NO_AUTO_RESAMPLE | SND_PCM_NO_AUTO_CHANNELS | SND_PCM_NO_AUTO_FORMAT;

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
    snd_pcm_t* pcm = nullptr;
    int error = 0;
    if (file.empty()) {
        error = snd_pcm_open(&pcm, name.c_str(), SND_PCM_STREAM_PLAYBACK, mode);
    } else {
        const Config config = merged(file);
        error = snd_pcm_open_lconf(&pcm, name.c_str(), SND_PCM_STREAM_PLAYBACK, mode, config.get());
    }
    check(error, "ALSA device " + name + ": cannot be opened");
    return {pcm, [](void* opened) { snd_pcm_close(static_cast<snd_pcm_t*>(opened)); }};
}

}  // namespace shaker

#pragma once
// What the PCMs of the mock sound card allow, for libasound's plug-ins.
#include <alsa/asoundlib.h>
#include <alsa/pcm_external.h>

#include <initializer_list>
#include <vector>

namespace shaker::mock {

/// Interleaved samples of 16 to 32 bits at this rate with these channel counts, or only that of the key
/// `channels` of `conf`; periods and buffers of nearly any length. Returns libasound's negative error number.
inline int constrain(snd_pcm_ioplug_t* io, snd_config_t* conf, double rate_hz,
                     std::initializer_list<unsigned> channel_counts) {
    std::vector<unsigned> channels{channel_counts};
    snd_config_t* entry = nullptr;
    long only = 0;
    if (snd_config_search(conf, "channels", &entry) == 0 && snd_config_get_integer(entry, &only) == 0)
        channels = {static_cast<unsigned>(only)};
    const unsigned access[] = {SND_PCM_ACCESS_RW_INTERLEAVED};
    const unsigned formats[] = {SND_PCM_FORMAT_S16_LE, SND_PCM_FORMAT_S24_LE, SND_PCM_FORMAT_S24_3LE,
                                SND_PCM_FORMAT_S32_LE};
    const auto rate = static_cast<unsigned>(rate_hz);
    constexpr unsigned least_bytes = 64, most_bytes = 1U << 22U, most_periods = 4096;
    int error = snd_pcm_ioplug_set_param_list(io, SND_PCM_IOPLUG_HW_ACCESS, 1, access);
    if (error == 0) error = snd_pcm_ioplug_set_param_list(io, SND_PCM_IOPLUG_HW_FORMAT, 4, formats);
    if (error == 0)
        error = snd_pcm_ioplug_set_param_list(io, SND_PCM_IOPLUG_HW_CHANNELS,
                                              static_cast<unsigned>(channels.size()), channels.data());
    if (error == 0) error = snd_pcm_ioplug_set_param_list(io, SND_PCM_IOPLUG_HW_RATE, 1, &rate);
    if (error == 0)
        error = snd_pcm_ioplug_set_param_minmax(io, SND_PCM_IOPLUG_HW_PERIOD_BYTES, least_bytes, most_bytes);
    if (error == 0)
        error = snd_pcm_ioplug_set_param_minmax(io, SND_PCM_IOPLUG_HW_BUFFER_BYTES, least_bytes, most_bytes);
    if (error == 0) error = snd_pcm_ioplug_set_param_minmax(io, SND_PCM_IOPLUG_HW_PERIODS, 2, most_periods);
    return error;
}

}  // namespace shaker::mock

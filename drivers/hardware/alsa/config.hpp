#pragma once
// Opens a PCM by its name, with definitions from an additional file.
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace shaker::alsa {

/// A snd_pcm_t, closed by the destructor.
using AlsaHandle = std::unique_ptr<void, void (*)(void*)>;

/// Opens the playback PCM `name`, non-blocking and without conversions by libasound. `config` is read after
/// the system's configuration (empty: none). Waits up to 2 s for a busy device. Throws DeviceError.
AlsaHandle open_alsa_playback(const std::string& name, const std::filesystem::path& config);

/// The usual rates in Hz, and the channel counts up to 32, that a configuration space allows: a
/// snd_pcm_hw_params_t of this snd_pcm_t.
std::vector<int> possible_rates_hz(void* pcm, void* hw);
std::vector<int> possible_channels(void* pcm, void* hw);

}  // namespace shaker::alsa

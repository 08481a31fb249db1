#pragma once
// Opening a PCM by its name, with definitions from a file of our own.
#include <filesystem>
#include <memory>
#include <string>

namespace shaker {

/// A snd_pcm_t, closed at the end of its life.
using AlsaHandle = std::unique_ptr<void, void (*)(void*)>;

/// The playback PCM `name`, non-blocking and without any conversion put in by libasound. `config` is read
/// after the system's configuration (empty: none). Waits up to 2 s for a device that is busy. Throws
/// DeviceError.
AlsaHandle open_alsa_playback(const std::string& name, const std::filesystem::path& config);

}  // namespace shaker

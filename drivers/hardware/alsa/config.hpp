#pragma once
// Opens a PCM by its name, with definitions from an additional file.
#include <filesystem>
#include <memory>
#include <new>
#include <string>
#include <vector>

#include "drivers/hardware/alsa/settings.hpp"

namespace shaker::alsa {

/// A snd_pcm_t, closed by the destructor.
using AlsaHandle = std::unique_ptr<void, void (*)(void*)>;

/// An object of libasound with the functions that make and release it: snd_pcm_status_t.
template <class T>
using AlsaOwned = std::unique_ptr<T, void (*)(T*)>;
template <class T>
AlsaOwned<T> made(int (*make)(T**), void (*release)(T*)) {
    T* object = nullptr;
    if (make(&object) < 0) throw std::bad_alloc{};
    return {object, release};
}

enum class Direction { playback, capture };

/// Opens the PCM `name`, non-blocking and without conversions by libasound. `config` is read after
/// the system's configuration (empty: none). Waits up to 2 s for a busy device. Throws DeviceError.
AlsaHandle open_alsa(Direction direction, const std::string& name, const std::filesystem::path& config);
/// A snd_ctl_t: the controls of a card, by the name of its control device. Throws DeviceError.
AlsaHandle open_control(const std::string& name, const std::filesystem::path& config);
/// The programs that hold PCMs of this direction: "pipewire (process 812)", joined by commas; empty: none.
/// card: its number, negative: of any. asound, proc: where the kernel lists them.
std::string holders(Direction direction, int card, const std::filesystem::path& asound = "/proc/asound",
                    const std::filesystem::path& proc = "/proc");
/// The long name of the sound card behind a PCM; empty without a card.
std::string card_name(void* pcm);
/// Its snd_pcm_format_t.
int format_number(SampleFormat format) noexcept;

/// The usual rates in Hz, and the channel counts up to 32, that a configuration space allows: a
/// snd_pcm_hw_params_t of this snd_pcm_t.
std::vector<int> possible_rates_hz(void* pcm, void* hw);
std::vector<int> possible_channels(void* pcm, void* hw);
/// The formats of shakerd, and the rates, that such a space allows, in words.
std::string allowed_formats(void* pcm, void* hw);
std::string allowed_rates(void* pcm, void* hw);

}  // namespace shaker::alsa

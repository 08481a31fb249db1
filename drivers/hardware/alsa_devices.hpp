#pragma once
// What can play here: the sound cards' devices and what each can do.
#include <filesystem>
#include <string>
#include <vector>

#include "drivers/hardware/alsa_settings.hpp"

namespace shaker {

/// A playback PCM. Ranges are those of a stream whose other parameters are still free.
struct AlsaDevice {
    struct Between {
        unsigned least = 0, most = 0;
    };
    std::string
        pcm;  // to write into a rig file; a card's is hw:CARD=<its id>,DEV=<number>: the same after a restart
    std::string name;   // for people
    std::string error;  // why it could not be asked; empty: the rest is valid
    std::vector<SampleFormat> formats;
    std::vector<int> rates_hz;  // of the usual ones
    Between channels, period_frames, buffer_frames;

    /// One line for an operator.
    [[nodiscard]] std::string text() const;
};

/// All playback devices of all sound cards. One that is busy is listed with its error. Empty without a card.
std::vector<AlsaDevice> list_alsa_devices();

/// One PCM by its name, also one that only `config` (may be empty) defines. What goes wrong is in `error`.
AlsaDevice describe_alsa_device(const std::string& pcm, const std::filesystem::path& config);

}  // namespace shaker

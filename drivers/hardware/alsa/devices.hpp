#pragma once
// Lists the playback devices of the sound cards and their properties.
#include <filesystem>
#include <string>
#include <vector>

#include "drivers/hardware/alsa/settings.hpp"

namespace shaker::alsa {

/// A playback PCM. Ranges hold while the other parameters are free.
struct AlsaDevice {
    struct Between {
        unsigned least = 0, most = 0;
    };
    std::string pcm;   // for a rig file; of a card hw:CARD=<id>,DEV=<number>, which a restart does not change
    std::string name;  // as shown to people
    std::string error;  // why it could not be queried; empty: the fields below are valid
    std::vector<SampleFormat> formats;
    std::vector<int> rates_hz;  // supported ones of the usual rates
    Between channels, period_frames, buffer_frames;

    /// One line for an operator.
    [[nodiscard]] std::string text() const;
};

/// All playback devices of all sound cards. One that is busy is listed with its error. Empty without a card.
std::vector<AlsaDevice> list_alsa_devices();

/// Describes one PCM by its name; `config` (may be empty) may define it. Errors are in `error`.
AlsaDevice describe_alsa_device(const std::string& pcm, const std::filesystem::path& config);

}  // namespace shaker::alsa

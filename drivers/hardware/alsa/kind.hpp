#pragma once
// The row of this folder in a table of kinds, and the devices that are connected.
#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "drivers/hardware/alsa/config.hpp"
#include "drivers/hardware/alsa/mixer.hpp"
#include "drivers/hardware/alsa/settings.hpp"
#include "drivers/hardware/kind/device_kind.hpp"

namespace shaker::alsa {

/// A PCM of one direction. Ranges hold while the other parameters are free.
struct AlsaDevice {
    struct Between {
        unsigned least = 0, most = 0;
    };
    std::string pcm;   // for a rig file; of a card hw:CARD=<id>,DEV=<number>, which a restart does not change
    std::string name;  // as shown to people
    std::string error;  // why it could not be queried; empty: the fields below are valid
    std::vector<SampleFormat> formats;
    std::vector<int> rates_hz, channels;  // as possible_rates_hz() and possible_channels()
    Between period_frames, buffer_frames;

    /// One line for an operator.
    [[nodiscard]] std::string text() const;
};

/// All devices of all sound cards. One that is busy is listed with its error. Empty without a card.
std::vector<AlsaDevice> list_alsa_devices(Direction direction);

/// Describes one PCM by its name; `config` (may be empty) may define it. Errors are in `error`.
AlsaDevice describe_alsa_device(Direction direction, const std::string& pcm,
                                const std::filesystem::path& config);

/// The same as rows of a list, by the search options below.
std::vector<hardware::ListedDevice> listed(Direction direction, const hardware::Search& search);

hardware::OpenDac read_kind(SettingsTable& table);
std::vector<hardware::ListedDevice> list_kind(const hardware::Search& search);

inline constexpr std::array search_options{
    hardware::SearchOption{
        .name = "--pcm", .value = "PCM", .help = "Show this PCM instead of those of the sound cards"},
    hardware::SearchOption{.name = "--alsa-config",
                           .value = "FILE",
                           .help = "ALSA configuration that defines the PCM",
                           .file = true}};

inline constexpr hardware::DacKind alsa_kind{
    .name = "alsa",
    .heading = "[dac]",
    .key = "dacs",
    .read = read_kind,
    .list = list_kind,
    .search = search_options,
    .advice = {.silent = "is another program using the PCM?",
               .rate_off = "does a plug-in (plughw, a sound server) convert the rate?"},
    .mixer = mixer_at};

}  // namespace shaker::alsa

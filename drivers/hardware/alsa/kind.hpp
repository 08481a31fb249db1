#pragma once
// The row of this folder in a table of kinds, and the devices that are connected.
#include <array>
#include <vector>

#include "drivers/hardware/alsa/config.hpp"
#include "drivers/hardware/alsa/mixer.hpp"
#include "drivers/hardware/kind/device_kind.hpp"

namespace shaker::alsa {

/// All devices of all sound cards, or the PCM of the search options below. One that is busy is listed with
/// its error. Ranges hold while the other parameters are free.
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

#pragma once
// The row of this folder in a table of kinds, and the inputs that are connected.
#include <vector>

#include "drivers/hardware/alsa/mixer.hpp"
#include "drivers/hardware/kind/device_kind.hpp"

namespace shaker::alsa_input {

hardware::OpenAccelerometer read_kind(SettingsTable& table);
std::vector<hardware::ListedDevice> list_kind(const hardware::Search& search);

/// The options of the search are those of the kind of DACs.
inline constexpr hardware::AccelerometerKind alsa_input_kind{
    .name = "alsa",
    .heading = "[accelerometer] driver = \"alsa\"",
    .key = "inputs",
    .read = read_kind,
    .list = list_kind,
    .advice = {.silent = "is another program using the input?",
               .rate_off = "does a plug-in (plughw, a sound server) convert the rate?"},
    .mixer = alsa::mixer_at};

}  // namespace shaker::alsa_input

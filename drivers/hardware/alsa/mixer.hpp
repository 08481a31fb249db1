#pragma once
// The controls of a sound card, which other programs can change.
#include <optional>
#include <string>

#include "drivers/devices.hpp"
#include "drivers/settings_table.hpp"

namespace shaker::alsa {

/// The control device of a PCM of a card, "hw:CARD=M4" of "hw:CARD=M4,DEV=0"; empty for another PCM.
std::string control_of(const std::string& pcm);

/// The mixer that a table with `pcm` and `alsa_config` has: the key `mixer` names the control device, without
/// it that of the PCM's card. Names are as `amixer contents` prints them, values are separated by commas,
/// enumerated ones as numbers. Empty: it has none.
std::optional<MixerDevice> mixer_at(SettingsTable& table);

}  // namespace shaker::alsa

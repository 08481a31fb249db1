#pragma once
// The controls of a sound card, which other programs can change.
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "drivers/devices.hpp"
#include "drivers/settings_table.hpp"

namespace shaker::alsa {

/// All controls of the card now. A line has the name as `amixer contents` prints it, " = " and the values,
/// separated by commas; enumerated ones as numbers. Lines of controls that cannot be compared (read only,
/// volatile, inactive) begin with "- ". control: libasound's name, "hw:CARD=M4". Throws DeviceError.
Mixer read_mixer(const std::string& control, const std::filesystem::path& config);

/// Sets every control of `wanted` that can be compared and has other values now. Returns their names.
/// DeviceError for one that is missing or refuses.
std::vector<std::string> restore_mixer(const Mixer& wanted, const std::filesystem::path& config);

/// The control device of a PCM of a card, "hw:CARD=M4" of "hw:CARD=M4,DEV=0"; empty for another PCM.
std::string control_of(const std::string& pcm);

/// The mixer that a table with `pcm` and `alsa_config` has: the key `mixer` names the control device, without
/// it that of the PCM's card. Empty: it has none.
std::optional<MixerDevice> mixer_at(SettingsTable& table);

}  // namespace shaker::alsa

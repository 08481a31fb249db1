#pragma once
// Harmonics of an acceleration as typed by a person.
#include <string_view>

#include "drivers/drive.hpp"

namespace shaker::command_line {

/// "1:4.9@0,2:0.5g@35deg": order, amplitude and phase against sin(q w t) of each harmonic; without @ the
/// phase is 0. Throws InputError that names the option, the item and what is allowed.
Harmonics<Acceleration> parse_harmonics(std::string_view option, std::string_view text);

}  // namespace shaker::command_line

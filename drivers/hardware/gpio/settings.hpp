#pragma once
// Settings of a line of a GPIO chip in a rig file: [abort].
#include <string>

#include "drivers/settings_table.hpp"

namespace shaker::gpio {

/// One line of a chip.
struct LineName {
    std::string chip;  // its name, label or device file: "gpiochip0", "/dev/gpiochip0"
    std::string line;  // its name, or its number: "17"
    [[nodiscard]] std::string text() const { return "line " + line + " of " + chip; }
    bool operator==(const LineName&) const = default;
};

/// Resistor that the chip connects to an input.
enum class Pull { up, down, off };

struct AbortSettings {
    LineName at;
    Pull pull = Pull::up;
    bool closed_high = false;  // level with a closed contact
    double read_s = 0.01;      // longest time between two readings
};

/// Keys as the members above; `chip` and `line` are required. `closed` is the level of a closed contact,
/// "low" or "high". A line without connection must read as open, so that it cannot be the level of `pull`.
/// Throws InputError.
AbortSettings read_abort(SettingsTable& table);

}  // namespace shaker::gpio

#pragma once
// A normally closed contact between an input line of a GPIO chip and ground or supply: its settings in a rig
// file, [abort], and its line, which is the seam between the kernel's chips and the lines of tests.
#include <chrono>
#include <memory>
#include <optional>
#include <string>

#include "drivers/devices.hpp"
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

class InputLine {
public:
    virtual ~InputLine() = default;
    /// Level now, and levels since the last call.
    struct Levels {
        bool high = false;
        bool was_high = false, was_low = false;
    };
    /// Waits at most `wait` for an edge, then reads the level. Empty if the line cannot be read.
    [[nodiscard]] virtual std::optional<Levels> watch(std::chrono::milliseconds wait) noexcept = 0;
};

/// The number of a line of a chip with `count` lines; empty: the line has a name. DeviceError for a number
/// that the chip does not have.
std::optional<unsigned> line_number(const LineName& at, unsigned count);
/// Opens a line; throws DeviceError, which names it.
using OpenInput = std::unique_ptr<InputLine> (*)(const LineName&, Pull);
/// A line of the kernel's chips. An input of a chip without edge events is read at the end of each wait.
std::unique_ptr<InputLine> open_input(const LineName& at, Pull pull);

/// An edge ends the wait; without edges the level is read every read_s. An opening between two readings is
/// reported.
class ContactInput final : public AbortInput {
public:
    ContactInput(std::unique_ptr<InputLine> line, const AbortSettings& settings);
    [[nodiscard]] Contact read(std::chrono::milliseconds wait) noexcept override;

private:
    std::unique_ptr<InputLine> line_;
    AbortSettings settings_;
    bool readable_ = true;
};

}  // namespace shaker::gpio

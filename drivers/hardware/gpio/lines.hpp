#pragma once
// Lines of GPIO chips: the seam between the kernel's chips and the lines of tests.
#include <chrono>
#include <memory>
#include <optional>

#include "drivers/hardware/gpio/settings.hpp"

namespace shaker::gpio {

/// Low when it is opened, and released when it is destroyed or the process ends.
class OutputLine {
public:
    virtual ~OutputLine() = default;
    /// False if the chip refuses, for example because it is gone.
    [[nodiscard]] virtual bool set(bool high) noexcept = 0;
};

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

/// How lines are opened. Both throw DeviceError, which names the line.
struct Lines {
    std::unique_ptr<OutputLine> (*output)(const LineName&);
    std::unique_ptr<InputLine> (*input)(const LineName&, Pull);
};

/// The number of a line of a chip with `count` lines; empty: the line has a name. DeviceError for a number
/// that the chip does not have.
std::optional<unsigned> line_number(const LineName& at, unsigned count);
std::unique_ptr<OutputLine> open_output(const LineName& at);
/// An input of a chip without edge events is read at the end of each wait.
std::unique_ptr<InputLine> open_input(const LineName& at, Pull pull);
/// Lines of the kernel's chips.
inline constexpr Lines chip_lines{open_output, open_input};

}  // namespace shaker::gpio

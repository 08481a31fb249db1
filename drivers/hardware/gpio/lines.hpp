#pragma once
// Input lines of GPIO chips: the seam between the kernel's chips and the lines of tests.
#include <chrono>
#include <memory>
#include <optional>

#include "drivers/hardware/gpio/settings.hpp"

namespace shaker::gpio {

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

}  // namespace shaker::gpio

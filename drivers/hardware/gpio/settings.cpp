#include "drivers/hardware/gpio/settings.hpp"

namespace shaker::gpio {

namespace {

LineName read_line(SettingsTable& table) {
    LineName at{table.text("chip"), table.text("line")};
    if (at.chip.empty()) table.fail("chip", "expected the name of a GPIO chip (gpiodetect lists them)");
    if (at.line.empty())
        table.fail("line", "expected the name or the number of a line (gpioinfo lists them)");
    return at;
}

}  // namespace

AbortSettings read_abort(SettingsTable& table) {
    AbortSettings s{.at = read_line(table)};
    s.pull = static_cast<Pull>(table.choice("pull", {"up", "down", "off"}, 0));
    s.closed_high = table.choice("closed", {"low", "high"}, s.pull == Pull::down ? 1 : 0) == 1;
    if ((s.pull == Pull::up && s.closed_high) || (s.pull == Pull::down && !s.closed_high))
        table.fail("closed",
                   "a broken wire would read as a closed contact: pull = \"up\" needs closed = \"low\", "
                   "pull = \"down\" needs closed = \"high\"");
    return s;
}

}  // namespace shaker::gpio

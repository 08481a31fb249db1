#include "drivers/hardware/gpio/contact_input.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <thread>
#include <utility>

namespace shaker::gpio {

ContactInput::ContactInput(std::unique_ptr<InputLine> line, const AbortSettings& settings)
    : line_{std::move(line)}, settings_{settings} {}

Contact ContactInput::read(std::chrono::milliseconds wait) noexcept {
    const std::chrono::milliseconds most{std::lround(1e3 * settings_.read_s)};
    const auto seen = line_->watch(std::min(wait, most));
    if (seen.has_value() != std::exchange(readable_, seen.has_value()))
        spdlog::error("abort input: {} {}", settings_.at.text(),
                      readable_ ? "can be read again" : "cannot be read");
    if (!seen) {
        std::this_thread::sleep_for(std::min(wait, most));  // a chip that is gone does not wait
        return Contact::unreadable;
    }
    const bool was_open = settings_.closed_high ? seen->was_low : seen->was_high;
    return was_open || seen->high != settings_.closed_high ? Contact::open : Contact::closed;
}

}  // namespace shaker::gpio

#include "drivers/hardware/gpio/contact_input.hpp"

#include <gpiod.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <span>
#include <thread>
#include <utility>

#include "drivers/errors.hpp"

namespace shaker::gpio {

namespace {

constexpr const char* consumer = "shakerd";

struct CloseChip {
    void operator()(gpiod_chip* chip) const noexcept { gpiod_chip_close(chip); }  // releases its lines
};

[[noreturn]] void fail(const LineName& at, const std::string& what) {
    throw DeviceError{"GPIO " + at.text() + ": " + what};
}

[[noreturn]] void fail_no_line(const LineName& at, unsigned count) {
    fail(at, "no such line; expected a name of gpioinfo or a number from 0 to " + std::to_string(count - 1));
}

/// One line with a handle of its chip.
struct OpenLine {
    std::unique_ptr<gpiod_chip, CloseChip> chip;
    gpiod_line* line;

    explicit OpenLine(const LineName& at) : chip{gpiod_chip_open_lookup(at.chip.c_str())} {
        if (!chip)
            fail(at, std::string{"the chip cannot be opened: "} + std::strerror(errno) +
                         " (gpiodetect lists the chips)");
        const unsigned count = gpiod_chip_num_lines(chip.get());
        const std::optional<unsigned> number = line_number(at, count);
        line = number ? gpiod_chip_get_line(chip.get(), *number)
                      : gpiod_chip_find_line(chip.get(), at.line.c_str());
        if (line == nullptr) fail_no_line(at, count);
    }
};

class ChipInput final : public InputLine {
public:
    ChipInput(const LineName& at, Pull pull) : open_{at} {
        const int flags = pull == Pull::up     ? GPIOD_LINE_REQUEST_FLAG_BIAS_PULL_UP
                          : pull == Pull::down ? GPIOD_LINE_REQUEST_FLAG_BIAS_PULL_DOWN
                                               : 0;
        events_ = gpiod_line_request_both_edges_events_flags(open_.line, consumer, flags) == 0;
        if (!events_ && gpiod_line_request_input_flags(open_.line, consumer, flags) < 0)
            fail(at, std::string{"cannot be an input with this pull: "} + std::strerror(errno));
    }
    [[nodiscard]] std::optional<Levels> watch(std::chrono::milliseconds wait) noexcept override {
        Levels seen;
        if (events_) {
            const timespec limit{.tv_sec = wait.count() / 1000, .tv_nsec = wait.count() % 1000 * 1'000'000};
            const timespec none{};
            for (int came = gpiod_line_event_wait(open_.line, &limit); came != 0;
                 came = gpiod_line_event_wait(open_.line, &none)) {
                std::array<gpiod_line_event, 16> events;
                const int n =
                    came < 0 ? -1 : gpiod_line_event_read_multiple(open_.line, events.data(), events.size());
                if (n < 0) return std::nullopt;
                for (const gpiod_line_event& e : std::span{events}.first(static_cast<std::size_t>(n)))
                    (e.event_type == GPIOD_LINE_EVENT_RISING_EDGE ? seen.was_high : seen.was_low) = true;
            }
        } else {
            std::this_thread::sleep_for(wait);
        }
        const int level = gpiod_line_get_value(open_.line);
        if (level < 0) return std::nullopt;
        seen.high = level > 0;
        return seen;
    }

private:
    OpenLine open_;
    bool events_;
};

LineName read_line(SettingsTable& table) {
    LineName at{table.text("chip"), table.text("line")};
    if (at.chip.empty()) table.fail("chip", "expected the name of a GPIO chip (gpiodetect lists them)");
    if (at.line.empty())
        table.fail("line", "expected the name or the number of a line (gpioinfo lists them)");
    return at;
}

}  // namespace

std::optional<unsigned> line_number(const LineName& at, unsigned count) {
    unsigned number = 0;
    const char* const end = at.line.data() + at.line.size();
    const auto [rest, error] = std::from_chars(at.line.data(), end, number);
    if (error == std::errc::invalid_argument || rest != end) return std::nullopt;
    if (error != std::errc{} || number >= count) fail_no_line(at, count);
    return number;
}

std::unique_ptr<InputLine> open_input(const LineName& at, Pull pull) {
    return std::make_unique<ChipInput>(at, pull);
}

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

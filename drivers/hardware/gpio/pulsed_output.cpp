#include "drivers/hardware/gpio/pulsed_output.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include "drivers/realtime.hpp"

namespace shaker::gpio {

PulsedOutput::PulsedOutput(std::unique_ptr<OutputLine> line, const EnableSettings& settings)
    : line_{std::move(line)}, settings_{settings}, thread_{[this](const std::stop_token& stop) {
          run(stop);
      }} {}

void PulsedOutput::feed(bool on) noexcept {
    on_ = on;
    ++blocks_;
}

void PulsedOutput::run(const std::stop_token& stop) {
    using Clock = std::chrono::steady_clock;
    const auto steps = [](double s) {
        return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>{s});
    };
    static_cast<void>(name_thread("enable output"));
    if (settings_.fifo_priority > 0)
        if (const std::string refused = use_fifo_priority(settings_.fifo_priority); !refused.empty())
            spdlog::debug("enable output: {}", refused);
    const Clock::duration half = steps(0.5 / settings_.toggle_hz), hold = steps(settings_.hold_s);
    std::uint64_t seen = blocks_;
    Clock::time_point fed_at = Clock::now() - 2 * hold, next = Clock::now();
    bool high = false, works = true;
    while (!stop.stop_requested()) {
        next = std::max(next + half, Clock::now());
        std::this_thread::sleep_until(next);
        const Clock::time_point now = Clock::now();
        if (const std::uint64_t blocks = blocks_; blocks != seen) {
            seen = blocks;
            fed_at = now;
        }
        const bool toggles = on_ && now - fed_at <= hold;
        if (!toggles && !high) continue;
        high = toggles && !high;
        const bool done = line_->set(high);
        if (!done && works)
            spdlog::error("enable output: {} cannot be set; the amplifier switches off", settings_.at.text());
        works = done;
    }
    static_cast<void>(line_->set(false));
}

}  // namespace shaker::gpio

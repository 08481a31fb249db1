#pragma once
// PulsedOutput: a line that toggles while the output thread plays blocks and the drive is on.
#include <atomic>
#include <cstdint>
#include <memory>
#include <thread>

#include "drivers/devices.hpp"
#include "drivers/hardware/gpio/lines.hpp"

namespace shaker::gpio {

/// Toggles in a thread of its own, which the output thread feeds through two atomics. The line rests low.
/// It stops within hold_s and half a period after the last feed(true), and within half a period after a
/// feed(false), the end of the process or the loss of the chip.
/// Thread safety: feed() is called by one thread.
class PulsedOutput final : public EnableOutput {
public:
    PulsedOutput(std::unique_ptr<OutputLine> line, const EnableSettings& settings);
    [[nodiscard]] double before_s() const noexcept override { return settings_.before_s; }
    void feed(bool on) noexcept override;

private:
    void run(const std::stop_token& stop);

    std::unique_ptr<OutputLine> line_;
    EnableSettings settings_;
    std::atomic<bool> on_{false};
    std::atomic<std::uint64_t> blocks_{0};  // fed so far
    std::jthread thread_;                   // last: ends before the members that it uses
};

}  // namespace shaker::gpio

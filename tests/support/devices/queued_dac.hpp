#pragma once
// A DAC without a clock that keeps all samples by their ticks and takes back those in its queue.
#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "drivers/devices.hpp"

namespace shaker::test {

class QueuedDac final : public Dac {
public:
    /// queue: samples that wait after each write; kept: those that cannot be taken back. enable_before_s: as
    /// in DacInfo.
    explicit QueuedDac(std::int64_t queue = 0, std::int64_t kept = 0, double enable_before_s = 0)
        : queue_{queue}, kept_{kept}, enable_before_s_{enable_before_s} {}
    [[nodiscard]] DacInfo info() const override {
        return {.name = "queued",
                .rate_hz = 48000,
                .full_scale_V = 1,
                .queue_frames = queue_,
                .kept_frames = kept_,
                .enable_before_s = enable_before_s_};
    }
    PlayTime write(std::span<const double> volts, std::span<const double> trigger) override {
        const std::int64_t tick = std::ssize(given);
        given.insert(given.end(), volts.begin(), volts.end());
        triggers.insert(triggers.end(), trigger.begin(), trigger.end());
        tone.resize(triggers.size(), enabled);
        const std::int64_t lost = std::exchange(loses, 0);
        given.resize(given.size() + static_cast<std::size_t>(lost));
        triggers.resize(given.size());
        tone.resize(given.size());
        played = std::max(played, std::ssize(given) - (lost > 0 ? 0 : queue_));
        return {{tick}, HostTime{std::chrono::nanoseconds{tick * 20833}}, lost};
    }
    std::int64_t take_back(std::int64_t most) noexcept override {
        if (fails) return 0;
        const std::int64_t n = std::clamp<std::int64_t>(std::ssize(given) - played - kept_, 0, most);
        given.resize(given.size() - static_cast<std::size_t>(n));
        triggers.resize(given.size());
        tone.resize(given.size());
        taken_back += n;
        return n;
    }
    void enable(bool on) noexcept override { enabled = on; }
    void stop() noexcept override {}

    std::vector<double> given, triggers;
    std::vector<char> tone;       // 1 for each sample with the enable tone
    bool enabled = false;         // the next samples have the enable tone
    std::int64_t played = 0;      // samples that have left the queue
    std::int64_t loses = 0;       // samples lost with the next write
    std::int64_t taken_back = 0;  // samples so far
    bool fails = false;           // take_back()

private:
    std::int64_t queue_, kept_;
    double enable_before_s_;
};

}  // namespace shaker::test

#pragma once
// Heartbeat: a sign of life of one thread for others.
#include <atomic>
#include <chrono>

namespace shaker::remote {

/// Thread safety: one thread beats, any thread reads.
class Heartbeat {
    using Clock = std::chrono::steady_clock;

public:
    void beat() noexcept { newest_ = Clock::now().time_since_epoch().count(); }
    /// Time since the newest beat, or since the start.
    [[nodiscard]] std::chrono::nanoseconds age() const noexcept {
        return Clock::now().time_since_epoch() - Clock::duration{newest_.load()};
    }

private:
    std::atomic<Clock::rep> newest_{Clock::now().time_since_epoch().count()};
};

}  // namespace shaker::remote

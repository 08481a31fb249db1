#pragma once
// Two ways to run the same steps: all in one thread on virtual time, or one thread per loop on real time.
#include <algorithm>
#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "drivers/devices.hpp"
#include "drivers/time.hpp"

namespace shaker::acquisition {

/// The operating system's answer to a request for real time.
struct RealTimeGrant {
    std::string what;     // "memory" (locked), or the name of a thread (its stack and priority)
    std::string refused;  // reason and remedy; empty: granted
};

/// One loop of a run. `step` does one piece of work and waits for it at most the given time; false: there was
/// nothing to do.
struct Loop {
    std::string name;       // thread name, at most 15 characters
    int fifo_priority = 0;  // SCHED_FIFO priority of its thread; 0: ordinary
    bool waits = true;      // `step` waits for a device; false: the thread pauses after a step without work
    std::function<bool(std::chrono::milliseconds)> step;
    double fifo_share = 0.9;             // most processor time at that priority, share of each 20 ms
    std::chrono::milliseconds pause{1};  // after a step without work
};

/// What a run does when its threads have begun and when a loop fails.
struct RunHooks {
    /// Called once before the first step, with all requests for real time; empty: none was made.
    std::function<void(const std::vector<RealTimeGrant>&)> begun = [](const std::vector<RealTimeGrant>&) {};
    /// The loop with this index has thrown. The other loops continue until this returns true, at most
    /// longest_wind_down_s.
    std::function<bool(std::size_t index)> wound_down = [](std::size_t) { return true; };
};
inline constexpr double longest_wind_down_s = 5;

/// Keeps virtual time from running ahead of real time.
class Pacer {
public:
    /// Longest pause of the computer that virtual time makes up for by running faster, s. After a longer
    /// pause virtual time continues where it was.
    static constexpr double made_up_s = 0.02;
    /// Waits until virtual time s. Real time starts with the first call; longer pauses do not count.
    void wait_until(double s);

private:
    std::optional<std::chrono::steady_clock::time_point> begin_;
};

/// Calls every loop in turn, each until it has nothing to do, until `done`. The first loop (the output) moves
/// virtual time and does one step per round. Deterministic. A loop that throws ends the run after
/// hooks.wound_down; its exception is thrown from here. Returns the real time, s.
double run_lockstep(std::vector<Loop>& loops, const std::function<bool()>& done, const RunHooks& hooks = {});

/// Runs each loop in its own thread until `done`, which the last loop (the reduction) calls after each of its
/// steps. Then calls `unblock`, so that no loop waits for a device any more, and joins all threads. A loop
/// that throws ends the run after hooks.wound_down; the first exception is thrown from here. Returns the real
/// time, s.
double run_threaded(std::vector<Loop>& loops, const std::function<bool()>& done,
                    const std::function<void()>& unblock, const RunHooks& hooks = {});

/// A simulated DAC that accepts samples only at their real rate, so that virtual time keeps to real time.
class PacedDac final : public Dac {
public:
    explicit PacedDac(std::unique_ptr<Dac> inner)
        : inner_{std::move(inner)}, rate_hz_{inner_->info().rate_hz} {}
    [[nodiscard]] DacInfo info() const override { return inner_->info(); }
    [[nodiscard]] DeviceCounts counts() const noexcept override { return inner_->counts(); }
    PlayTime write(std::span<const double> volts, std::span<const double> trigger) override {
        pacer_.wait_until(duration_s(written_, rate_hz_));
        const std::int64_t again = std::min(owed_, std::ssize(volts));
        owed_ -= again;
        written_ += std::ssize(volts) - again;
        return inner_->write(volts, trigger);
    }
    std::int64_t take_back(std::int64_t most) noexcept override {
        const std::int64_t taken = inner_->take_back(most);
        owed_ += taken;
        return taken;
    }
    void enable(bool on) noexcept override { inner_->enable(on); }
    void stop() noexcept override { inner_->stop(); }

private:
    std::unique_ptr<Dac> inner_;
    double rate_hz_;
    std::int64_t written_ = 0;  // samples
    std::int64_t owed_ = 0;     // samples that were taken back and not written again yet
    Pacer pacer_;
};

}  // namespace shaker::acquisition

#pragma once
// Two ways to run the same steps: all in one thread on virtual time, or one thread per loop on real time.
#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace shaker::acquisition {

/// One loop of a run. `step` does one piece of work and waits for it at most the given time; false: there was
/// nothing to do.
struct Loop {
    std::string name;       // thread name, at most 15 characters
    int fifo_priority = 0;  // SCHED_FIFO priority of its thread; 0: ordinary
    bool waits = true;      // `step` waits for a device; false: the thread pauses after a step without work
    std::function<bool(std::chrono::milliseconds)> step;
};

/// Duration of a run, and the operating system's refusals.
struct Execution {
    double wall_s = 0;                 // real time
    std::vector<std::string> refused;  // refused real-time requests, one sentence each
};

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
/// virtual time and does one step per round. Deterministic.
Execution run_lockstep(std::vector<Loop>& loops, const std::function<bool()>& done);

/// Runs each loop in its own thread until `done`, which the last loop (the reduction) calls after each of its
/// steps. Then calls `unblock`, so that no loop waits for a device any more, and joins all threads. A loop
/// that throws ends the run; its exception is thrown from here.
Execution run_threaded(std::vector<Loop>& loops, const std::function<bool()>& done,
                       const std::function<void()>& unblock);

}  // namespace shaker::acquisition

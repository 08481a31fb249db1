#pragma once
// Two ways to run one set of steps: in one thread on virtual time, or one thread a loop on real time.
#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace shaker::acquisition {

/// One loop of a run. `step` does one piece of work, waiting for it at most as long as told; false: nothing
/// to do.
struct Loop {
    std::string name;       // thread name, at most 15 characters
    int fifo_priority = 0;  // SCHED_FIFO priority of its thread; 0: ordinary
    bool waits = true;      // on a device, in `step`; if not, its thread pauses when there was nothing
    std::function<bool(std::chrono::milliseconds)> step;
};

/// What running took and what the system refused.
struct Execution {
    double wall_s = 0;
    std::vector<std::string> refused;  // of real-time scheduling, one sentence each
};

/// Waits for real time where virtual time is ahead of it.
class Pacer {
public:
    /// What may be made up for by going faster than real time, s. What the computer stood still beyond it is
    /// left behind: virtual time goes on from where it was.
    static constexpr double made_up_s = 0.02;
    /// Returns when s seconds, and what was left behind, have passed since the first call's s.
    void wait_until(double s);

private:
    std::optional<std::chrono::steady_clock::time_point> begin_;
};

/// Calls every loop in turn, each until it has nothing to do, until `done`. Deterministic: the first loop is
/// the one that moves virtual time (the output) and does one step a round.
Execution run_lockstep(std::vector<Loop>& loops, const std::function<bool()>& done);

/// One thread a loop until `done`, asked by the last loop (the reduction) after each of its steps; then
/// `unblock` is called so that no loop waits on a device any more, and all are joined. A loop that throws
/// ends the run and its error is thrown from here.
Execution run_threaded(std::vector<Loop>& loops, const std::function<bool()>& done,
                       const std::function<void()>& unblock);

}  // namespace shaker::acquisition

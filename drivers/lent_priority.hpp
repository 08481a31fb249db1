#pragma once
// LentPriority: a real-time priority for a bounded share of a processor.
#include <pthread.h>

#include <chrono>
#include <string>
#include <thread>

namespace shaker {

/// Raises a thread to SCHED_FIFO. A thread that used more than its share of a processor in the last 20 ms has
/// the ordinary priority for the next 20 ms, so that no thread, and no library inside it, can keep the
/// processors from the threads that stop the drive. An own thread, one priority higher, watches it.
class LentPriority {
public:
    static constexpr std::chrono::milliseconds window{20};
    static constexpr double half = 0.5;

    /// priority: 1 to 98. share: of a processor; above 1: no bound. The thread must outlive this object.
    /// Does not throw when the watching thread cannot be started: the priority is then refused.
    LentPriority(pthread_t thread, int priority, double share = half);
    ~LentPriority() = default;
    LentPriority(const LentPriority&) = delete;
    LentPriority& operator=(const LentPriority&) = delete;

    /// The refusal of the operating system; empty: the priority was granted.
    [[nodiscard]] const std::string& refused() const noexcept { return refused_; }

private:
    void watch(const std::stop_token& stop) const;

    pthread_t thread_;
    int priority_;
    double share_;
    std::string refused_;
    std::jthread watcher_;
};

}  // namespace shaker

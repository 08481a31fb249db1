#pragma once
// LentPriority: a real-time priority for a bounded share of a processor.
#include <pthread.h>

#include <chrono>
#include <string>
#include <thread>

namespace shaker::remote {

/// Raises a thread to SCHED_FIFO, so that an abort is read while pictures keep all processors busy. A thread
/// that used more than half of a processor in the last 20 ms, because of many requests, has the ordinary
/// priority for the next 20 ms, so that clients cannot take the processor from pictures and reduction. An own
/// thread, one priority higher, watches it.
class LentPriority {
public:
    static constexpr std::chrono::milliseconds window{20};

    /// priority: 1 to 98. The thread must outlive this object.
    LentPriority(pthread_t thread, int priority);
    ~LentPriority() = default;
    LentPriority(const LentPriority&) = delete;
    LentPriority& operator=(const LentPriority&) = delete;

    /// The refusal of the operating system; empty: the priority was granted.
    [[nodiscard]] const std::string& refused() const noexcept { return refused_; }

private:
    void watch(const std::stop_token& stop) const;

    pthread_t thread_;
    int priority_;
    std::string refused_;
    std::jthread watcher_;
};

}  // namespace shaker::remote

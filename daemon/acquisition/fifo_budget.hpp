#pragma once
// Bounds the processor time that a thread takes at its real-time priority, so that it cannot starve the
// threads that stop the drive.
#include <chrono>

namespace shaker::acquisition {

/// A thread that has used more than its share of a tenth of a second continues at ordinary priority until the
/// next tenth. One thread, which calls everything.
class FifoBudget {
public:
    /// priority: of this thread, SCHED_FIFO; 0: ordinary, nothing is done. share: 0..1; 1: no bound.
    FifoBudget(int priority, double share) noexcept;
    /// Call it after each piece of work.
    void spend() noexcept;
    /// True while the thread is at ordinary priority.
    [[nodiscard]] bool spent() const noexcept { return spent_; }

private:
    int priority_;
    double share_;
    bool spent_ = false;
    std::chrono::steady_clock::time_point since_{};
    double used_s_ = 0;  // processor time of the thread at since_
};

}  // namespace shaker::acquisition

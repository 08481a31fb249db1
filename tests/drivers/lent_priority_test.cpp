#include "drivers/lent_priority.hpp"

#include <gtest/gtest.h>
#include <sched.h>

#include <atomic>

namespace shaker {
namespace {

using namespace std::chrono_literals;

int policy_of(pthread_t thread) {
    int policy = -1;
    sched_param parameters{};
    pthread_getschedparam(thread, &policy, &parameters);
    return policy;
}

/// True when the thread has this policy within half a second.
bool becomes(pthread_t thread, int policy) {
    for (int i = 0; i < 500 && policy_of(thread) != policy; ++i) std::this_thread::sleep_for(1ms);
    return policy_of(thread) == policy;
}

/// A thread that takes a whole processor, or none.
struct Worker {
    std::atomic<bool> busy{false};
    std::jthread thread{[this](const std::stop_token& stop) {
        while (!stop.stop_requested())
            if (!busy) std::this_thread::sleep_for(1ms);
    }};
    pthread_t handle = thread.native_handle();
};

TEST(LentPriorityTest, BusyThreadHasItForItsShareOfTheTimeOnly) {
    for (const double share : {LentPriority::half, 0.9}) {
        Worker worker;
        const LentPriority priority{worker.handle, 2, share};
        if (!priority.refused().empty()) GTEST_SKIP() << priority.refused();
        EXPECT_EQ(policy_of(worker.handle), SCHED_FIFO);
        worker.busy = true;
        EXPECT_TRUE(becomes(worker.handle, SCHED_OTHER)) << share;
        worker.busy = false;
        std::this_thread::sleep_for(2 * LentPriority::window);
        EXPECT_TRUE(becomes(worker.handle, SCHED_FIFO)) << share;
    }
}

TEST(LentPriorityTest, FullShareIsNotBounded) {
    Worker worker;
    const LentPriority priority{worker.handle, 2, 1.5};
    if (!priority.refused().empty()) GTEST_SKIP() << priority.refused();
    worker.busy = true;
    std::this_thread::sleep_for(3 * LentPriority::window);
    EXPECT_EQ(policy_of(worker.handle), SCHED_FIFO);
}

}  // namespace
}  // namespace shaker

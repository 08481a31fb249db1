#include "daemon/acquisition/fifo_budget.hpp"

#include <gtest/gtest.h>
#include <sched.h>

#include <thread>

#include "drivers/realtime.hpp"

namespace shaker::acquisition {
namespace {

void work_for(double s) {
    const double until = thread_time_s() + s;
    while (thread_time_s() < until) {
    }
}

TEST(FifoBudgetTest, BusyThreadLosesItsPriorityForATime) {
    std::thread{[] {
        if (const std::string refused = use_fifo_priority(1); !refused.empty()) GTEST_SKIP() << refused;
        FifoBudget budget{1, 0.3};
        budget.spend();
        work_for(0.01);
        budget.spend();
        EXPECT_EQ(sched_getscheduler(0), SCHED_FIFO) << "a tenth of the time";
        work_for(0.03);
        budget.spend();
        EXPECT_EQ(sched_getscheduler(0), SCHED_OTHER);
        EXPECT_TRUE(budget.spent());
        std::this_thread::sleep_for(std::chrono::milliseconds{110});
        budget.spend();
        EXPECT_EQ(sched_getscheduler(0), SCHED_FIFO) << "the next tenth of a second";
    }}.join();
}

TEST(FifoBudgetTest, FullShareIsNotBounded) {
    FifoBudget budget{1, 1};
    work_for(0.12);
    budget.spend();
    EXPECT_FALSE(budget.spent());
}

}  // namespace
}  // namespace shaker::acquisition

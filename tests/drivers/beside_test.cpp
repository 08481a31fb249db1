// Work beside the thread that leads a drive.
#include "drivers/beside.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <vector>

namespace shaker {
namespace {

using namespace std::chrono_literals;

TEST(BesideTest, WorkIsDoneInOrderInOneThread) {
    Beside beside{"beside", true};
    std::vector<int> done;
    std::vector<std::future<std::thread::id>> threads;
    for (int i = 0; i < 5; ++i)
        threads.push_back(beside.run([&done, i] {
            done.push_back(i);
            return std::this_thread::get_id();
        }));
    const std::thread::id first = threads.front().get();
    EXPECT_NE(first, std::this_thread::get_id());
    for (std::size_t i = 1; i < threads.size(); ++i) EXPECT_EQ(threads[i].get(), first);
    EXPECT_EQ(done, (std::vector{0, 1, 2, 3, 4}));
}

TEST(BesideTest, InLockstepTheCallerDoesTheWork) {
    Beside beside{"beside", false};
    auto result = beside.run([] { return std::this_thread::get_id(); });
    ASSERT_TRUE(is_ready(result));
    EXPECT_EQ(result.get(), std::this_thread::get_id());
}

TEST(BesideTest, ExceptionsComeWithTheResult) {
    for (const bool threaded : {false, true}) {
        Beside beside{"beside", threaded};
        auto result = beside.run([]() -> int { throw std::runtime_error{"no data"}; });
        EXPECT_THROW(result.get(), std::runtime_error);
        EXPECT_EQ(beside.run([] { return 7; }).get(), 7) << "the thread goes on";
    }
}

TEST(BesideTest, EndAsksWorkToStopAndDropsWhatWaits) {
    std::atomic<bool> begun = false, stopped = false, second = false;
    std::future<void> dropped;
    {
        Beside beside{"beside", true};
        auto first = beside.run([&](const std::stop_token& stop) {
            begun = true;
            while (!stop.stop_requested()) std::this_thread::sleep_for(1ms);
            stopped = true;
        });
        dropped = beside.run([&] { second = true; });
        while (!begun) std::this_thread::sleep_for(1ms);
    }
    EXPECT_TRUE(stopped);
    EXPECT_FALSE(second);
    EXPECT_THROW(dropped.get(), std::future_error);
}

}  // namespace
}  // namespace shaker

// A DAC that keeps to real time fills up at once what was taken back.
#include <gtest/gtest.h>

#include "daemon/acquisition/executors.hpp"
#include "tests/support/devices/queued_dac.hpp"

namespace shaker::acquisition {
namespace {

TEST(PacedDacTest, RefillsWithoutWaitingThenKeepsPace) {
    constexpr std::size_t block = 240;  // 5 ms
    PacedDac dac{std::make_unique<test::QueuedDac>(4800, 480)};
    const std::vector<double> volts(block);
    const auto seconds_for = [&](std::int64_t blocks) {
        const auto begin = std::chrono::steady_clock::now();
        for (; blocks > 0; --blocks) dac.write(volts, volts);
        return std::chrono::duration<double>{std::chrono::steady_clock::now() - begin}.count();
    };
    seconds_for(30);
    const std::int64_t taken = dac.take_back(1 << 20);
    ASSERT_EQ(taken, 4320);  // 90 ms
    EXPECT_LT(seconds_for(taken / std::ssize(volts)), 0.06);
    EXPECT_GT(seconds_for(20), 0.07);
}

}  // namespace
}  // namespace shaker::acquisition

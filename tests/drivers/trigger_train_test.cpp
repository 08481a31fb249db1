#include "drivers/trigger_train.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace shaker {
namespace {

TEST(TriggerTrainTest, PulsesAreAtNearestSamplesForAnyRate) {
    TriggerTrain train{48000, 190};
    std::vector<double> out(144000);
    train.fill(out);
    std::int64_t k = 0;
    for (std::size_t n = 0; n < out.size(); ++n) {
        const bool due = static_cast<std::int64_t>(n) == TriggerTrain::pulse(k, 48000, 190);
        ASSERT_EQ(out[n], due ? 1 : 0) << n;
        if (due) ++k;
    }
    EXPECT_EQ(k, 3 * 190);
}

TEST(TriggerTrainTest, ContinuesOnGridAfterSkip) {
    for (const double fps : {1000.0, 190.0, 7.3})
        for (const std::int64_t lost : {1, 47, 48, 49, 252, 253, 12345}) {
            TriggerTrain whole{48000, fps}, skipped{48000, fps};
            std::vector<double> all(40000), part(100);
            whole.fill(all);
            skipped.fill(part);
            skipped.skip(lost);
            std::vector<double> rest(all.size() - part.size() - static_cast<std::size_t>(lost));
            skipped.fill(rest);
            EXPECT_TRUE(std::equal(rest.rbegin(), rest.rend(), all.rbegin())) << fps << " " << lost;
        }
}

TEST(TriggerTrainTest, NoRateMeansNoPulses) {
    TriggerTrain train{48000, 0};
    std::vector<double> out(1000, 5);
    train.fill(out);
    train.skip(100);
    train.fill(out);
    for (const double x : out) EXPECT_EQ(x, 0);
}

}  // namespace
}  // namespace shaker

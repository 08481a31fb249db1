#include "daemon/reduction/stick.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "tests/support/synthetic_run.hpp"

namespace shaker {
namespace {

std::vector<StickInterval> sticks(double gamma_g, double phi, double noise = 2e-6) {
    SyntheticRun run;
    run.may_stick = true;
    run.drive = {20, gamma_g * paper_g, 0.5, phi};
    run.position_noise_m = noise;
    return reduce(make_measurement(run)).stick;
}

struct Known {
    double gamma_g, phi, from, to;  // event times of the exact walker, units of T
};

class KnownStickTest : public ::testing::TestWithParam<Known> {};

TEST_P(KnownStickTest, IsFoundWhereTheExactWalkerHasIt) {
    const Known& k = GetParam();
    const auto found = sticks(k.gamma_g, k.phi);
    ASSERT_EQ(found.size(), 1U);
    EXPECT_NEAR(found[0].from, k.from, 2.5 * found[0].sd);
    EXPECT_NEAR(found[0].to, k.to, 2.5 * found[0].sd);
    EXPECT_LT(found[0].sd, 0.02);
}

INSTANTIATE_TEST_SUITE_P(Walkers, KnownStickTest,
                         ::testing::Values(Known{0.5, 0, 0.5057, 0.7072},
                                           Known{0.68, 3 * std::numbers::pi / 4, 0.1032, 0.2544},
                                           Known{2, std::numbers::pi / 2, 0.2156, 0.2944}));

TEST(StickTest, CrossingsWithoutStickAreNotCalledOne) {
    // phi 0 from 0.9535 g on and phi 3 pi/4 at 3 g: two velocity matches, no rest
    EXPECT_TRUE(sticks(1, 0).empty());
    EXPECT_TRUE(sticks(2, 0).empty());
    EXPECT_TRUE(sticks(3, 3 * std::numbers::pi / 4).empty());
    EXPECT_TRUE(sticks(2, 0, 0.2e-6).empty());
}

TEST(StickTest, AWalkerBelowTheThresholdRestsAllThePeriod) {
    const auto found = sticks(0.1, 0);
    ASSERT_EQ(found.size(), 1U);
    EXPECT_EQ(found[0].from, 0);
    EXPECT_EQ(found[0].to, 1);
}

}  // namespace
}  // namespace shaker

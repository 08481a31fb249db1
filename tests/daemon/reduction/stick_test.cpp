#include "daemon/reduction/stick.hpp"

#include <gtest/gtest.h>

#include <array>
#include <numbers>

#include "tests/support/run/synthetic_run.hpp"

namespace shaker::reduction {
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

TEST_P(KnownStickTest, IsFoundWhereExactWalkerSticks) {
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

TEST(StickTest, ReportsNoStickAtCrossings) {
    // phi 0 from 0.9535 g on and phi 3 pi/4 at 3 g: two velocity matches, no rest
    EXPECT_TRUE(sticks(1, 0).empty());
    EXPECT_TRUE(sticks(2, 0).empty());
    EXPECT_TRUE(sticks(3, 3 * std::numbers::pi / 4).empty());
    EXPECT_TRUE(sticks(2, 0, 0.2e-6).empty());
}

Reduction reduced(double gamma_g, double phi, double frame_rate_hz, double noise_m = 2e-6) {
    SyntheticRun run;
    run.may_stick = true;
    run.drive = {20, gamma_g * paper_g, 0.5, phi};
    run.position_noise_m = noise_m;
    run.frame_rate_hz = frame_rate_hz;
    return reduce(make_measurement(run));
}

// Stick intervals of the exact walker: 0.2015 T, 0.1512 T and 0.0788 T. Only intervals below the shortest
// visible one may be missed.
TEST(StickTest, HiddenStickIsBelowTheShortestVisible) {
    int hidden = 0;
    for (const auto& [gamma_g, phi, length] : {std::array{0.5, 0.0, 0.2015},
                                               {0.68, 3 * std::numbers::pi / 4, 0.1512},
                                               {2.0, std::numbers::pi / 2, 0.0788}})
        for (const double frame_rate_hz : {1000.0, 200.0, 130.0})
            for (const double noise_m : {2e-6, 20e-6, 100e-6}) {
                const Reduction r = reduced(gamma_g, phi, frame_rate_hz, noise_m);
                if (!r.stick.empty()) continue;
                ++hidden;
                EXPECT_GT(r.shortest_visible_stick, length)
                    << gamma_g << " g at " << frame_rate_hz << " frames/s, noise " << noise_m;
            }
    EXPECT_GT(hidden, 3);
}

TEST(StickTest, ShortestVisibleStickShrinksWithRateAndLessNoise) {
    const double fine = reduced(1, 0, 1000, 0.5e-6).shortest_visible_stick;
    const double coarse = reduced(1, 0, 200, 0.5e-6).shortest_visible_stick;
    const double noisy = reduced(1, 0, 1000, 50e-6).shortest_visible_stick;
    EXPECT_GE(fine, 0.02) << "a frame is 0.02 T";
    EXPECT_GE(coarse, 0.1) << "a frame is 0.1 T";
    EXPECT_GT(coarse, fine);
    EXPECT_GT(noisy, fine);
    EXPECT_LE(noisy, 1);
}

TEST(StickTest, WalkerBelowThresholdRestsWholePeriod) {
    const auto found = sticks(0.1, 0);
    ASSERT_EQ(found.size(), 1U);
    EXPECT_EQ(found[0].from, 0);
    EXPECT_EQ(found[0].to, 1);
    EXPECT_GE(found[0].sd, 0.009) << "half a frame is 0.01 T";
}

// At the threshold of motion, 0.1254 g, the slips are shorter than can be seen.
TEST(StickTest, RestNearThresholdAgreesWithDrift) {
    for (const double gamma_g : {0.12, 0.125, 0.128, 0.13, 0.132, 0.134, 0.136, 0.138, 0.14}) {
        for (std::uint64_t seed = 1; seed <= 5; ++seed) {
            SyntheticRun run;
            run.may_stick = true;
            run.drive.gamma = gamma_g * paper_g;
            run.seed = seed;
            const Reduction r = reduce(make_measurement(run));
            const bool moves = std::abs(r.v_D.value) > 3 * r.v_D.sigma;
            const bool rests = r.stick.size() == 1 && r.stick[0].from == 0 && r.stick[0].to == 1;
            EXPECT_FALSE(moves && rests) << gamma_g << " g, seed " << seed;
            for (const StickInterval& stick : r.stick) EXPECT_GT(stick.sd, 0);
        }
    }
}

}  // namespace
}  // namespace shaker::reduction

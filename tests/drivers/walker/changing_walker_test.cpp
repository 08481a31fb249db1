#include "drivers/walker/changing_walker.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "drivers/walker/steady_state.hpp"
#include "tests/support/walker/walker_settings.hpp"

namespace shaker::walker {
namespace {

struct Statistics {
    double mean = 0, sd = 0, correlation = 0;
};
Statistics statistics(const MuChange& change, int count) {
    MuHistory history{change, 0.05};
    std::vector<double> factors;
    Statistics s;
    for (int i = 0; i < count; ++i) {
        factors.push_back(history.next());
        s.mean += factors.back() / count;
    }
    double squares = 0, products = 0;
    for (std::size_t i = 0; i < factors.size(); ++i) {
        squares += (factors[i] - s.mean) * (factors[i] - s.mean);
        if (i > 0) products += (factors[i] - s.mean) * (factors[i - 1] - s.mean);
    }
    s.sd = std::sqrt(squares / count);
    s.correlation = products / squares;
    return s;
}

TEST(MuHistoryTest, JitterHasItsWidthAndMemory) {
    constexpr int count = 200000;
    for (const double memory : {0.0, 0.5, 0.9}) {
        const Statistics s = statistics({.jitter = 0.02, .memory = memory}, count);
        const double independent = count * (1 - memory) / (1 + memory);
        EXPECT_NEAR(s.mean, 1, 4 * 0.02 / std::sqrt(independent));
        EXPECT_NEAR(s.sd, 0.02, 4 * 0.02 / std::sqrt(2 * independent));
        EXPECT_NEAR(s.correlation, memory, 4 / std::sqrt(count));
    }
}

TEST(MuHistoryTest, SeedGivesSameFactors) {
    const MuChange change{.jitter = 0.1, .memory = 0.9, .seed = 5};
    MuChange other = change;
    other.seed = 6;
    MuHistory a{change, 0.05}, b{change, 0.05}, c{other, 0.05};
    int differences = 0;
    for (int i = 0; i < 100; ++i) {
        const double factor = a.next();
        EXPECT_EQ(factor, b.next());
        differences += factor != c.next() ? 1 : 0;
    }
    EXPECT_EQ(differences, 100);
}

TEST(MuHistoryTest, RelaxesWithItsTimeConstant) {
    MuHistory history{{.relaxation = 0.3, .relaxation_s = 1}, 0.05};
    EXPECT_EQ(history.next(), 1.3);
    for (int k = 1; k < 20; ++k) history.next();
    EXPECT_NEAR(history.next(), 1 + 0.3 / std::numbers::e, 1e-15);
}

TEST(RoughSurfaceTest, HasItsWidth) {
    const RoughSurface surface{{.share = 0.1, .length = 5e-3, .seed = 2}};
    constexpr int count = 100000;
    double mean = 0, squares = 0;
    for (int i = 0; i < count; ++i) {
        const double off = surface.factor(1e-4 * i) - 1;
        mean += off / count;
        squares += off * off / count;
    }
    EXPECT_NEAR(mean, 0, 1e-3);
    EXPECT_NEAR(std::sqrt(squares), 0.1, 2e-3);
}

TEST(ChangingWalkerTest, ConstantMuGivesExactWalker) {
    const WalkerSetting setting = paper_setting(0.5, 0);
    const WalkerLaw law{setting};
    Walker exact{law};
    ChangingWalker walker{setting};
    for (int k = 0; k < 20; ++k) {
        EXPECT_NEAR(walker.advance_period(), exact.advance_period(), 1e-15 * law.velocity_scale());
        EXPECT_NEAR(walker.now().v, exact.now().v, 1e-15);
    }
}

TEST(ChangingWalkerTest, RelaxedMuGivesDriftOfFinalMu) {
    WalkerSetting setting = paper_setting(1, 0.5);
    const double final_drift = settle(setting).v_D;
    setting.friction.change.relaxation = 0.5;
    setting.friction.change.relaxation_s = 0.5;
    ChangingWalker walker{setting};
    const double first = walker.advance_period();
    for (int k = 0; k < 600; ++k) walker.advance_period();
    EXPECT_NEAR(walker.advance_period() * 20, final_drift, 1e-12);
    EXPECT_NE(first * 20, final_drift);
}

TEST(ChangingWalkerTest, JitterScattersAroundSettledDrift) {
    WalkerSetting setting = paper_setting(1, 0.5);
    const double settled = settle(setting).v_D;
    setting.friction.change = {.jitter = 0.02, .memory = 0.5};
    const MeanWalk walk = mean_walk(setting, 0, 50, 4000);
    // The mean of v_D(mu) exceeds v_D of the mean mu by its curvature only, 1e-4 here.
    EXPECT_NEAR(walk.v_D, settled, 4 * walk.v_D_error + 2e-4 * settled);
    EXPECT_GT(walk.v_D_error, 1e-7);
    EXPECT_LT(walk.v_D_error, 1e-2 * settled);
    EXPECT_NEAR(walk.mu_factor, 1, 2e-3);
}

TEST(ChangingWalkerTest, RoughSurfaceScattersDistances) {
    WalkerSetting setting = paper_setting(1, 0.5);
    const double smooth = settle(setting).v_D;
    setting.friction.roughness = {.share = 0.1, .length = 5e-3};
    const MeanWalk walk = mean_walk(setting, 0, 20, 320);
    EXPECT_NEAR(walk.v_D, smooth, 0.05 * smooth);
    EXPECT_GT(walk.v_D_error, 1e-6);
}

}  // namespace
}  // namespace shaker::walker

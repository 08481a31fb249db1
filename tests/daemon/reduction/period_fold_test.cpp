#include "daemon/reduction/period_fold.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "drivers/drive.hpp"

namespace shaker::reduction {
namespace {

constexpr double T = 0.05, D = 7e-4;
double position(double t) {
    return D * t / T + 3e-4 * std::sin(two_pi * t / T + 1) + 8e-5 * std::cos(2 * two_pi * t / T);
}

std::vector<PeriodFold::Period> fold(double rate, double seconds, auto keep) {
    PeriodFold fold(0.02, T);
    std::vector<PeriodFold::Period> out;
    for (int i = 0; i < seconds * rate; ++i) {
        const double t = i / rate;
        if (!keep(t)) continue;
        if (const auto done = fold.add(t, position(t), 2e-6)) out.push_back(*done);
    }
    return out;
}

TEST(PeriodFoldTest, DriftOfEveryPeriodForAnyFrameTimes) {
    for (const double rate : {1000.0, 997.0, 480.0, 1313.7}) {
        const auto periods = fold(rate, 0.5, [](double) { return true; });
        ASSERT_GE(periods.size(), 8U);
        EXPECT_TRUE(std::isnan(periods[0].drift.value));
        for (std::size_t i = 2; i < periods.size(); ++i) {
            // straight lines between frames miss A (w h)^2 / 12 = 4e-4 A at most, of which only changes count
            EXPECT_NEAR(periods[i].drift.value, D, 2e-4 * D) << rate << " period " << i;
            EXPECT_EQ(periods[i].k, periods[i - 1].k + 1);
        }
    }
}

TEST(PeriodFoldTest, ErrorCombinesTwoMeans) {
    const auto periods = fold(1000, 0.4, [](double) { return true; });
    // a frame on the border belongs to either period: 49 or 50
    EXPECT_NEAR(periods[3].drift.sigma, 2e-6 * std::sqrt(2 / 50.0), 5e-9);
}

TEST(PeriodFoldTest, LostFramesInvalidateTwoPeriods) {
    const auto periods = fold(1000, 0.6, [](double t) { return t < 0.231 || t > 0.25; });
    for (const auto& p : periods) {
        if (p.k == 0) continue;
        EXPECT_EQ(std::isnan(p.drift.value), p.k == 4 || p.k == 5) << p.k;  // period 4 is 0.22 to 0.27 s
    }
}

TEST(PeriodFoldTest, SkipsGapOfPeriods) {
    const auto periods = fold(1000, 0.8, [](double t) { return t < 0.2 || t > 0.4; });
    ASSERT_FALSE(periods.empty());
    EXPECT_GT(periods.back().k, 10);
    EXPECT_NEAR(periods.back().drift.value, D, 2e-4 * D);
}

// A camera's clock that was wrong for half a second: as many frames then fall into one period as into ten.
TEST(PeriodFoldTest, WrongTimesCostOnlyTheirPeriods) {
    PeriodFold fold{0, 0.05};
    std::vector<PeriodFold::Period> after;
    for (int i = 0; i < 3000; ++i) {
        const double t = 1e-3 * i, told = t >= 0.6 && t < 1.1 ? t + 0.7533 : t;
        const auto done = fold.add(told, D / 0.05 * t, 2e-6);
        if (done && t > 1.3) after.push_back(*done);
    }
    ASSERT_GT(after.size(), 30U);
    for (const auto& p : after) EXPECT_NEAR(p.drift.value, D, 1e-9) << p.k;
}

/// First length at which an approach from `start` sigma, shrinking by c, counts as settled; noise with a
/// seed.
std::size_t settles_at(double start, double c, double noise, unsigned seed) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal(0, noise);
    std::vector<double> drifts;
    for (int k = 0; k < 2000; ++k) {
        drifts.push_back(10 + start * std::pow(c, k) + normal(random));
        if (settled(drifts, 1)) return drifts.size();
    }
    return 0;
}

TEST(SettledTest, SevenTenthsApproachSettlesBelowTwoSigma) {
    int early = 0;
    for (unsigned seed = 0; seed < 500; ++seed) {
        const std::size_t n = settles_at(1000, 0.7, 1, seed);
        ASSERT_GT(n, 0U);
        early += 1000 * std::pow(0.7, static_cast<double>(n) - 1) > 2;
    }
    EXPECT_LE(early, 15);  // 3 %: noise may hide 2 sigma of it
}

TEST(SettledTest, SlowNoiseFreeApproachIsNotSettled) {
    for (const double c : {0.7, 0.9, 0.98, 0.995}) {
        // Without noise the steps all go one way: only rounding ends that.
        const std::size_t n = settles_at(1000, c, 0, 0);
        EXPECT_TRUE(n == 0 || 1000 * std::pow(c, static_cast<double>(n)) < 1e-3) << c;
    }
}

TEST(SettledTest, NoiseAloneSettlesSoon) {
    int late = 0;
    for (unsigned seed = 0; seed < 200; ++seed) late += settles_at(0, 0.5, 1, seed) > 12;
    EXPECT_LE(late, 20);
}

TEST(SettledTest, JumpIsNotSettled) {
    const std::vector<double> jump{1, 1.1, 0.9, 1, 1.1, 9};
    EXPECT_FALSE(settled(jump, 0.1));
}

TEST(SettledTest, ShortOrInvalidInputIsNotSettled) {
    const std::vector<double> few{1, 1, 1, 1, 1}, broken{1, 1.01, 1, NAN, 1, 1.01};
    EXPECT_FALSE(settled(few, 1));
    EXPECT_FALSE(settled(broken, 1));
    const std::vector<double> good{1, 1.01, 1, 1.01, 1, 1.01};
    EXPECT_TRUE(settled(good, 0.1));
    EXPECT_FALSE(settled(good, 0));
}

}  // namespace
}  // namespace shaker::reduction

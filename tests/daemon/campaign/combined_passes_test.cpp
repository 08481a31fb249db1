// Passes of a point are combined into one result whose error is right, also for few and short passes.
#include "daemon/campaign/combined_passes.hpp"

#include <gtest/gtest.h>

#include <numbers>
#include <random>

#include "daemon/reduction/drift_spread.hpp"
#include "drivers/drive.hpp"

namespace shaker::campaign {
namespace {

using calibration::Estimate;
using reduction::few_periods_factor;

TEST(CombinedPassesTest, OnePassKeepsItsNumbers) {
    const reduction::PassDrift one{{0.1234567890123, 4.5e-5}, 12};
    const reduction::CombinedDrift c = reduction::combined(std::span{&one, 1});
    EXPECT_EQ(c.v_D.value, one.v_D.value);
    EXPECT_EQ(c.v_D.sigma, one.v_D.sigma);
    EXPECT_TRUE(std::isnan(c.chi2));
    EXPECT_TRUE(std::isnan(reduction::combined({}).v_D.value));
}

struct Simulated {
    double covered = 0;     // share of results within 2 sigma of the truth
    double efficiency = 0;  // rms error of the best weights / rms error
};

// Passes whose means scatter as n^(-p/2), whose errors come from the scatter of their periods, with the
// widening of the reduction. between: further scatter between the passes, over the mean error of a pass.
Simulated simulate(const std::vector<int>& periods, double p, double between = 0) {
    constexpr int times = 4000;
    std::mt19937_64 random{7};
    std::normal_distribution<double> normal;
    int covered = 0;
    double squares = 0, best = 0;
    for (const int n : periods) best += 1 / (std::pow(n, -p) + between * between * std::pow(periods[0], -p));
    std::map<int, double> widening;
    for (const int n : periods) widening[n] = few_periods_factor(n - 1);
    for (int i = 0; i < times; ++i) {
        std::vector<reduction::PassDrift> passes;
        for (const int n : periods) {
            const double sigma = std::pow(n, -p / 2);
            std::chi_squared_distribution<double> chi2{n - 1.0};
            const double scatter = std::hypot(sigma, between * std::pow(periods[0], -p / 2));
            passes.push_back(
                {{scatter * normal(random), sigma * std::sqrt(chi2(random) / (n - 1)) * widening[n]}, n});
        }
        const Estimate v = reduction::combined(passes).v_D;
        covered += std::abs(v.value) < 2 * v.sigma ? 1 : 0;
        squares += v.value * v.value;
    }
    return {covered / double{times}, std::sqrt(times / best / squares)};
}

TEST(CombinedPassesTest, TwoErrorsCover95Percent) {
    const std::vector<std::vector<int>> cases{{5, 5},       {5, 5, 5},      std::vector<int>(10, 5),
                                              {10, 10},     {40, 40},       {35, 5},
                                              {20, 10, 10}, {12, 11, 13, 4}};
    for (const auto& periods : cases)
        for (const double p : {1.0, 3.0}) {
            const Simulated s = simulate(periods, p);
            // 4000 results tell a coverage to 0.3 %. It is above 95 % because chi2 below 1 does not
            // make the error smaller.
            EXPECT_GT(s.covered, 0.95) << testing::PrintToString(periods) << " p " << p;
            EXPECT_LT(s.covered, 0.98) << testing::PrintToString(periods) << " p " << p;
            EXPECT_GT(s.efficiency, 0.95) << testing::PrintToString(periods) << " p " << p;
        }
}

TEST(CombinedPassesTest, ErrorGrowsWhenPassesScatter) {
    // As much scatter between the passes as within: k passes tell it only to 1/sqrt(2 (k - 1)).
    EXPECT_GT(simulate({10, 10}, 1, 1).covered, 0.88);
    EXPECT_GT(simulate({10, 10, 10, 10, 10}, 1, 1).covered, 0.91);
    EXPECT_GT(simulate(std::vector<int>(20, 10), 1, 3).covered, 0.92);
}

TEST(CombinedPassesTest, PassWithLargeErrorCountsLess) {
    const std::vector<reduction::PassDrift> passes{{{1.0, 0.01}, 10}, {{1.0, 0.01}, 10}, {{2.0, 0.5}, 10}};
    const reduction::CombinedDrift c = reduction::combined(passes);
    EXPECT_LT(c.weights[2], 0.1);
    const std::vector<reduction::PassDrift> endless{{{1.0, 0.01}, 10},
                                                    {{9.0, std::numeric_limits<double>::infinity()}, 2}};
    EXPECT_EQ(reduction::combined(endless).v_D.value, 1.0) << "an error that is not finite does not count";
    EXPECT_EQ(reduction::combined(endless).weights, (std::vector<double>{1, 0}));
}

TEST(CombinedPassesTest, AnglesAreAveragedAcrossPi) {
    const double pi = std::numbers::pi;
    const std::vector<Estimate> angles{{pi - 0.01, 0.02}, {-pi + 0.03, 0.02}};
    const Estimate mean = reduction::weighted_angle(angles, std::vector<double>{0.5, 0.5});
    EXPECT_NEAR(mean.value, -pi + 0.01, 1e-12);
    EXPECT_NEAR(mean.sigma, std::sqrt(2) * std::hypot(0.02, 0.02) / 2, 1e-12) << "chi2 is 2";
}

reduction::Cycle cycle(int n, double offset, double drift) {
    reduction::Cycle c;
    for (int i = 0; i < n; ++i) {
        const double p = offset + static_cast<double>(i) / n;
        c.phase.push_back(p);
        c.x_m.push_back(std::sin(two_pi * p) + drift * p);
        c.v_mps.push_back(std::cos(two_pi * p) + 0.3 * std::sin(2 * two_pi * p));
        c.v_base_mps.push_back(std::cos(two_pi * p));
        c.x_sd_m.push_back(0.1);
        c.v_sd_mps.push_back(0.2 + 0.1 * std::cos(two_pi * p));
    }
    return c;
}

TEST(CombinedPassesTest, CycleIsResampledAtFixedPhases) {
    for (const auto& [n, offset] : {std::pair{50, 0.013}, {100, 0.0}, {200, 0.004}, {53, 0.0}}) {
        const reduction::Cycle c = resampled(cycle(n, offset, 0.5), 0.5);
        ASSERT_EQ(c.phase.size(), std::size_t{cycle_phases});
        EXPECT_EQ(c.x_m[0], 0);
        for (int k = 0; k < cycle_phases; ++k) {
            const auto i = static_cast<std::size_t>(k);
            const double p = k / double{cycle_phases};
            EXPECT_EQ(c.phase[i], p);
            // Cubic interpolation of sin(4 pi p): 3/128 (4 pi / n)^4, 1e-4 of its amplitude at 50 phases.
            EXPECT_NEAR(c.x_m[i], std::sin(two_pi * p) + 0.5 * p, 1e-5);
            EXPECT_NEAR(c.v_mps[i], std::cos(two_pi * p) + 0.3 * std::sin(2 * two_pi * p), 4e-5);
            EXPECT_NEAR(c.v_sd_mps[i], 0.2 + 0.1 * std::cos(two_pi * p), 1e-3);
        }
    }
    EXPECT_TRUE(resampled({}, 0).phase.empty());
}

TEST(CombinedPassesTest, MeanOfCyclesAndHarmonics) {
    const std::vector<reduction::Cycle> two{resampled(cycle(100, 0, 0.5), 0.5),
                                            resampled(cycle(100, 0, 0.7), 0.7)};
    const std::vector<double> weights{0.25, 0.75};
    const reduction::Cycle mean = weighted(two, weights);
    EXPECT_NEAR(mean.x_m[50], 0.5 * (0.25 * 0.5 + 0.75 * 0.7), 1e-9);
    EXPECT_NEAR(mean.x_sd_m[3], 0.1 * std::hypot(0.25, 0.75), 1e-12);

    reduction::Reduction a, b;
    a.harmonics = {{.q = 1, .amplitude = {2, 0.1}, .phase = {0, 0}},
                   {.q = 3, .amplitude = {1, 0.1}, .phase = {3, 0.1}}};
    b.harmonics = {{.q = 1, .amplitude = {3, 0.1}, .phase = {0, 0}},
                   {.q = 3, .amplitude = {1, 0.1}, .phase = {-3, 0.1}}};
    const std::vector<const reduction::Reduction*> passes{&a, &b};
    const std::vector<double> half{0.5, 0.5};
    EXPECT_NEAR(weighted(1, passes, half).amplitude.value, 2.5, 1e-12);
    const auto third = weighted(3, passes, half);
    EXPECT_NEAR(third.amplitude.value, -std::cos(3), 1e-12) << "as complex numbers";
    EXPECT_NEAR(std::abs(third.phase.value), std::numbers::pi, 1e-12);
    EXPECT_NEAR(third.amplitude.sigma, 0.1 / std::sqrt(2), 1e-12);
    EXPECT_TRUE(std::isnan(weighted(5, passes, half).amplitude.value)) << "not measured";
}

}  // namespace
}  // namespace shaker::campaign

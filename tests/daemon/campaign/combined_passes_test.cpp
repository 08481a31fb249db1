// Harmonics and cycles of the passes of a point are combined with the weights of their drift.
#include "daemon/campaign/combined_passes.hpp"

#include <gtest/gtest.h>

#include <numbers>
#include <random>

#include "drivers/drive.hpp"

namespace shaker::campaign {
namespace {

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

// The walker compared with an independent long double stepper, on random drives.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "tests/support/walker/fine_walker.hpp"
#include "tests/support/walker/walker_settings.hpp"

namespace shaker::walker {
namespace {

struct Kind {
    std::string name;
    int order = 2;
    double mu_s_over_mu_k = 1;
    double most_tilt = 0;      // rad
    double most_vertical = 0;  // of g, on each of two harmonics
    double most_viscous = 0;   // 1/s
};

WalkerSetting random_setting(std::mt19937_64& random, const Kind& kind) {
    WalkerSetting s;
    s.frequency = uniform(random, 5, 100);
    s.friction.mu_k = uniform(random, 0.05, 0.5);
    s.friction.mu_s = s.friction.mu_k * uniform(random, 1, 1 + 2 * (kind.mu_s_over_mu_k - 1));
    if (kind.mu_s_over_mu_k == 1) s.friction.mu_s = s.friction.mu_k;
    s.friction.viscous = uniform(random, 0, kind.most_viscous);
    s.tilt = uniform(random, -kind.most_tilt, kind.most_tilt);
    const double gamma = s.friction.mu_s * s.g * std::exp(uniform(random, 0, 4));
    s.base = random_harmonics(random, kind.order, gamma);
    s.vertical.at(1) = std::polar(uniform(random, 0, kind.most_vertical) * s.g, uniform(random, 0, two_pi));
    s.vertical.at(2) = std::polar(uniform(random, 0, kind.most_vertical) * s.g, uniform(random, 0, two_pi));
    return s;
}

class FineTest : public testing::TestWithParam<Kind> {};

TEST_P(FineTest, EventsEqualFineStepper) {
    std::mt19937_64 random{20240519};
    const int settings = GetParam().order > 4 ? 3 : 12, periods = 3;
    int events = 0;
    for (int i = 0; i < settings; ++i) {
        const WalkerSetting setting = random_setting(random, GetParam());
        const WalkerLaw law{setting};
        const double V = law.velocity_scale(), v_start = uniform(random, -1.5, 1.5) * V;
        Walker walker{law, v_start};
        FineWalker fine{setting, v_start};
        for (int k = 0; k < periods; ++k) {
            SCOPED_TRACE(GetParam().name + " setting " + std::to_string(i) + " period " + std::to_string(k));
            const double D = walker.advance_period();
            // Rounding of double over a few operations, where errors shrink from event to event.
            EXPECT_NEAR(D, static_cast<double>(fine.advance_period()), 2e-14 * V * law.period());
            EXPECT_NEAR(walker.now().v, static_cast<double>(fine.v()), 2e-14 * V);
            ASSERT_EQ(walker.events().size(), fine.events().size());
            for (std::size_t e = 0; e < walker.events().size(); ++e) {
                EXPECT_NEAR(walker.events()[e].phase, static_cast<double>(fine.events()[e].phase), 1e-12);
                EXPECT_EQ(static_cast<int>(walker.events()[e].from), fine.events()[e].from);
                EXPECT_EQ(static_cast<int>(walker.events()[e].to), fine.events()[e].to);
                ++events;
            }
        }
    }
    EXPECT_GT(events, settings * periods);
}

TEST(FineGrazeTest, ReleaseAfterJumpEqualsFineStepper) {
    // 2e-7 past the jump |a_B| exceeds mu_s g for a moment only: the root is nearly double.
    const double jumps[][3] = {
        {0.4807878, 0.3, 0.4}, {0.533334, std::numbers::pi / 2, 0.3}, {0.7970996, 0.3, 0.2}};
    for (const auto& [gamma, phi, mu_s] : jumps) {
        WalkerSetting setting = paper_setting(gamma * (1 + 2e-7), phi);
        setting.friction.mu_s = mu_s;
        const WalkerLaw law{setting};
        Walker walker{law};
        FineWalker fine{setting};
        for (int k = 0; k < 3; ++k) {
            EXPECT_NEAR(walker.advance_period(), static_cast<double>(fine.advance_period()), 1e-12);
            ASSERT_EQ(walker.events().size(), fine.events().size());
            for (std::size_t e = 0; e < walker.events().size(); ++e) {
                EXPECT_NEAR(walker.events()[e].phase, static_cast<double>(fine.events()[e].phase), 1e-11);
            }
        }
    }
}

INSTANTIATE_TEST_SUITE_P(
    Drives, FineTest,
    testing::Values(Kind{.name = "biharmonic"}, Kind{.name = "static friction", .mu_s_over_mu_k = 1.8},
                    Kind{.name = "tilted", .most_tilt = 0.04},
                    Kind{.name = "vertical", .mu_s_over_mu_k = 1.2, .most_vertical = 0.4},
                    Kind{.name = "viscous", .most_viscous = 50},
                    Kind{.name = "everything",
                         .order = 4,
                         .mu_s_over_mu_k = 1.5,
                         .most_tilt = 0.03,
                         .most_vertical = 0.3,
                         .most_viscous = 8},
                    Kind{.name = "sixteen harmonics", .order = 16},
                    Kind{.name = "sixteen harmonics and everything",
                         .order = 16,
                         .mu_s_over_mu_k = 1.3,
                         .most_tilt = 0.03,
                         .most_vertical = 0.3,
                         .most_viscous = 8}),
    [](const auto& kind) {
        std::string name = kind.param.name;
        std::replace(name.begin(), name.end(), ' ', '_');
        return name;
    });

}  // namespace
}  // namespace shaker::walker

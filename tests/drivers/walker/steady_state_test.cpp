// Laws of the settled walker, and the hard cases by name.
#include "drivers/walker/steady_state.hpp"

#include <gtest/gtest.h>

#include <string>

#include "drivers/errors.hpp"
#include "tests/support/walker/scenes.hpp"

namespace shaker::walker {
namespace {

constexpr double pi = std::numbers::pi;

double drift(const WalkerSetting& setting, double v_start = 0) {
    return settle(WalkerLaw{setting}, v_start).v_D;
}

WalkerSetting sticky(double gamma_in_g, double phi, double mu_s) {
    WalkerSetting s = paper_setting(gamma_in_g, phi);
    s.friction.mu_s = mu_s;
    return s;
}

TEST(SteadyStateTest, DriftMatchesExactOrbits) {
    // gamma in g, phi, v_D in mm/s printed to 4 decimals
    const double known[][3] = {{1, 0, 14.5824},
                               {2, 0, 36.5359},
                               {3, 0, 56.8514},
                               {10, 0, 194.4734},
                               {3, 3 * pi / 4, -30.4807},
                               {10, 3 * pi / 4, -127.7315},
                               {40, 3 * pi / 4, -541.5691},
                               {1, pi / 2, 9.1560},
                               {2, pi / 2, 10.9355}};
    for (const auto& [gamma, phi, v_D_mm] : known)
        EXPECT_NEAR(1e3 * drift(paper_setting(gamma, phi)), v_D_mm, 5.1e-5);
}

TEST(SteadyStateTest, ASingleHarmonicDoesNotMoveTheWalkerOn) {
    std::mt19937_64 random{1};
    for (int i = 0; i < 100; ++i) {
        WalkerSetting s;
        s.base.at(1 + i % 4) = std::polar(std::exp(uniform(random, -1, 6)), uniform(random, 0, two_pi));
        EXPECT_LT(std::abs(drift(s)), 1e-12) << i;
    }
}

TEST(SteadyStateTest, OddHarmonicsAloneDoNotMoveTheWalkerOn) {
    std::mt19937_64 random{2};
    for (int i = 0; i < 200; ++i) {
        WalkerSetting s;
        s.base = random_harmonics(random, 1 + 2 * (i % 8), std::exp(uniform(random, -1, 6)), 2);
        EXPECT_LT(std::abs(drift(s)), 1e-12) << i;
    }
}

TEST(SteadyStateTest, HalfATurnOfPhiReversesTheDrift) {
    std::mt19937_64 random{3};
    for (int i = 0; i < 100; ++i) {
        const double gamma = std::exp(uniform(random, -2, 3)), phi = uniform(random, -pi, pi);
        const double rho = uniform(random, 0.1, 0.9), V = gamma * paper_g / (two_pi * 20);
        EXPECT_NEAR(drift(paper_setting(gamma, phi + pi, rho)), -drift(paper_setting(gamma, phi, rho)),
                    1e-12 * V);
    }
}

TEST(SteadyStateTest, DriftOverVelocityScaleDependsOnGammaOverMuGAlone) {
    const WalkerSetting one = paper_setting(1.3, 0.7);
    WalkerSetting other = one;
    other.frequency = 73;
    other.friction = {0.226, 0.226, 0};
    for (auto& a : other.base.a) a *= 2;
    const WalkerLaw a{one}, b{other};
    EXPECT_NEAR(settle(a).v_D / a.velocity_scale(), settle(b).v_D / b.velocity_scale(), 1e-13);
}

TEST(SteadyStateTest, ATiltMovesTheWalkerEvenOnASingleHarmonic) {
    WalkerSetting s = paper_setting(1, 0, 1);
    s.tilt = pi / 180;
    EXPECT_NEAR(1e3 * drift(s), 18.4, 0.05);  // physics: 18.4 mm/s
    const double forward = drift(s);
    s.tilt = -s.tilt;
    EXPECT_NEAR(drift(s), -forward, 1e-13);
}

TEST(SteadyStateTest, ThresholdSeparatesRestFromFourEvents) {
    // In g, gamma_c: 2 a / g of the reference's drive over 1 - 1e-6.
    const double critical = 0.6291428490447 / 4.9;
    const SteadyState below = settle(WalkerLaw{paper_setting(critical * (1 - 1e-6), 0)});
    EXPECT_EQ(below.D, 0);
    EXPECT_TRUE(below.events.empty());
    EXPECT_EQ(below.rest_fraction, 1);
    const SteadyState above = settle(WalkerLaw{paper_setting(critical * (1 + 1e-6), 0)});
    EXPECT_EQ(above.events.size(), 4U);
    EXPECT_LT(std::abs(above.v_D), 1e-9);
    EXPECT_NEAR(settle(WalkerLaw{paper_setting(critical * 1.05, 0)}).v_D, -1.2e-7, 0.05e-7);
}

TEST(SteadyStateTest, DriftIsContinuousWhereStickVanishes) {
    const double gone = 0.953506;  // g, phi = 0
    const SteadyState below = settle(WalkerLaw{paper_setting(gone * (1 - 1e-6), 0)});
    const SteadyState above = settle(WalkerLaw{paper_setting(gone * (1 + 1e-6), 0)});
    EXPECT_EQ(below.events.size(), 3U);
    EXPECT_EQ(above.events.size(), 2U);
    EXPECT_NEAR(below.v_D, above.v_D, 1e-6);
}

TEST(SteadyStateTest, StaticFrictionMakesTheDriftJumpAtTheKnownGammas) {
    const struct {
        double gamma, phi, mu_s, below_mm, above_mm;
    } jumps[] = {{0.4807878, 0.3, 0.4, 3.982, 1.530},
                 {0.533333, pi / 2, 0.3, 9.512, 8.866},
                 {0.7970996, 0.3, 0.2, 12.638, 12.531}};
    // Past the jump v_D goes on like the square root of the distance: 3e-3 mm/s within these 2e-6 of gamma.
    for (const auto& jump : jumps) {
        EXPECT_NEAR(1e3 * drift(sticky(jump.gamma * (1 - 2e-6), jump.phi, jump.mu_s)), jump.below_mm, 1e-3);
        EXPECT_NEAR(1e3 * drift(sticky(jump.gamma * (1 + 2e-6), jump.phi, jump.mu_s)), jump.above_mm, 3e-3);
    }
}

TEST(SteadyStateTest, StaticFrictionCanHoldTwoCyclesAndTheStartChooses) {
    const WalkerLaw law{sticky(1.6772, 3.1302, 0.3)};
    bool sticks = false, slides = false;
    for (int i = -20; i <= 20; ++i) {
        const SteadyState s = settle(law, 0.05 * i * law.velocity_scale());
        const double expected = s.rest.empty() ? -29.6135 : -31.6656;  // mm/s
        EXPECT_NEAR(1e3 * s.v_D, expected, 1e-4);
        (s.rest.empty() ? slides : sticks) = true;
    }
    EXPECT_TRUE(sticks);
    EXPECT_TRUE(slides);
}

TEST(SteadyStateTest, WithOneFrictionEveryStartReachesTheSameCycle) {
    std::mt19937_64 random{4};
    for (int i = 0; i < 40; ++i) {
        const WalkerLaw law{paper_setting(std::exp(uniform(random, -1.5, 2)), uniform(random, -pi, pi))};
        const double V = law.velocity_scale(), from_rest = settle(law).v_D;
        EXPECT_NEAR(settle(law, V).v_D, from_rest, 1e-12 * V);
        EXPECT_NEAR(settle(law, -V).v_D, from_rest, 1e-12 * V);
    }
}

// Drives, overtones and tilts by a seed, from random velocities.
TEST(SteadyStateTest, NewtonFindsTheCycleOfManyPeriods) {
    std::mt19937 draw{7};
    const auto from_to = [&](double low, double high) {
        return std::uniform_real_distribution{low, high}(draw);
    };
    for (int i = 0; i < 300; ++i) {
        WalkerSetting s = paper_setting(from_to(0.1, 4), from_to(0, two_pi));
        if (i % 3 == 0) s.base.at(3) = std::polar(from_to(0, 0.3) * paper_g, from_to(0, two_pi));
        if (i % 5 == 0) s.tilt = from_to(-0.02, 0.02);
        const WalkerLaw law{s};
        const double scale = law.velocity_scale(), start = from_to(-2, 2) * scale;
        const SteadyState slow = settle(law, start), quick = settle_quickly(law, start);
        const double tolerance = 1e-12 * scale / (1 - std::min(slow.contraction, 0.999));
        EXPECT_NEAR(quick.v_D, slow.v_D, tolerance) << i;
        EXPECT_NEAR(quick.v0, slow.v0, tolerance) << i;
        EXPECT_EQ(quick.events.size(), slow.events.size()) << i;
    }
}

TEST(SteadyStateTest, ContractionIsDecayOfSmallError) {
    const WalkerLaw law{paper_setting(3, 0)};
    const SteadyState s = settle(law);
    const double error = 1e-6 * law.velocity_scale();
    Walker walker{law, s.v0 + error};
    walker.advance_period();
    EXPECT_NEAR((walker.now().v - s.v0) / error, s.contraction, 1e-5);
}

TEST(SteadyStateTest, SlowSettlingIsNotSettledAfterFourHundredPeriods) {
    const WalkerLaw law{scenes::slow_settling()};
    Walker walker{law, law.v_base_at_0()};  // from rest on the base
    for (int k = 0; k < 400; ++k) walker.advance_period();
    const SteadyState s = settle(law);
    EXPECT_NEAR(std::abs(walker.now().v - s.v0) / law.velocity_scale(), 3.4e-4, 0.05e-4);
    EXPECT_GT(s.periods, 1000);
}

TEST(SteadyStateTest, PeriodsToSettleFromRestAreThoseOfTheReference) {
    // gamma in g at phi = 0, first period whose D is right to 1e-3 and to 1e-6
    const int known[][3] = {{1, 5, 7}, {2, 15, 28}, {3, 24, 45}, {10, 81, 157}, {50, 405, 787}};
    for (const auto& [gamma, to_1e_3, to_1e_6] : known) {
        const WalkerLaw law{paper_setting(gamma, 0)};
        const double D = settle(law).D;
        Walker walker{law};
        const auto first_within = [&](double error) {
            while (std::abs(walker.advance_period() / D - 1) >= error) continue;
            return static_cast<int>(walker.period());
        };
        EXPECT_EQ(first_within(1e-3), to_1e_3);
        EXPECT_EQ(first_within(1e-6), to_1e_6);
    }
}

TEST(SteadyStateTest, BriefStickIsSeen) {
    const SteadyState s = settle(WalkerLaw{scenes::brief_stick()});
    ASSERT_EQ(s.rest.size(), 1U);
    EXPECT_NEAR(s.rest_fraction, 25.0 / 4000, 1.0 / 4000);
}

TEST(SteadyStateTest, ThresholdStickMatchesThePaper) {
    const SteadyState s = settle(WalkerLaw{scenes::threshold()});
    ASSERT_EQ(s.rest.size(), 1U);
    EXPECT_NEAR(s.rest[0].from, 0.5057, 1e-4);
    EXPECT_NEAR(s.rest[0].to, 0.7072, 1e-4);
    EXPECT_GT(s.v_D, 0);
}

TEST(SteadyStateTest, TheDriftChangesItsSignWithGammaAtThreeQuartersPi) {
    EXPECT_GT(drift(scenes::sign_flip(0.68)), 0);
    EXPECT_LT(drift(scenes::sign_flip(1.0)), 0);
    EXPECT_GT(drift(scenes::sign_flip(0.73)) * drift(scenes::sign_flip(0.735)), 0);
    EXPECT_LT(drift(scenes::sign_flip(0.73)) * drift(scenes::sign_flip(0.75)), 0);
}

TEST(SteadyStateTest, ViscousFrictionVanishesContinuously) {
    WalkerSetting s = paper_setting(3, 0.4);
    const double dry = drift(s);
    s.friction.viscous = 1e-9;
    EXPECT_NEAR(drift(s), dry, 1e-9);
    s.friction.viscous = 3.5;
    EXPECT_LT(drift(s), 0.8 * dry);
}

TEST(SteadyStateTest, SteepTiltHasNoSteadyMotion) {
    WalkerSetting s = paper_setting(0.5, 0);
    s.tilt = 0.12;  // tan 0.12 = 0.1206 > 0.113
    EXPECT_THROW(settle(WalkerLaw{s}), InputError);
    s.friction.viscous = 3.5;  // and a terminal velocity with damping
    EXPECT_NEAR(drift(s), (9.8 * std::sin(0.12) - 0.113 * 9.8 * std::cos(0.12)) / 3.5, 1e-12);
}

TEST(SteadyStateTest, WalkerStaysAtRestInSilenceOnTilt) {
    WalkerSetting s;
    EXPECT_EQ(settle(WalkerLaw{s}).D, 0);
    s.tilt = 0.1;  // tan 0.1 = 0.1003 < 0.113
    const SteadyState rest = settle(WalkerLaw{s});
    EXPECT_EQ(rest.D, 0);
    EXPECT_EQ(rest.rest_fraction, 1);
}

}  // namespace
}  // namespace shaker::walker

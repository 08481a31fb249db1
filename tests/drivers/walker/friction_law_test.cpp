// The laws of friction: symmetries, limits, and the values of the table of models.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "drivers/errors.hpp"
#include "drivers/walker/steady_state.hpp"
#include "tests/support/walker/walker_settings.hpp"

namespace shaker::walker {
namespace {

constexpr double pi = std::numbers::pi;
constexpr std::array laws{FrictionLaw::coulomb, FrictionLaw::logarithmic, FrictionLaw::dahl,
                          FrictionLaw::stribeck, FrictionLaw::lugre};

WalkerSetting with(FrictionLaw law, double gamma_in_g, double phi) {
    WalkerSetting s = paper_setting(gamma_in_g, phi);
    s.friction.law = law;
    return s;
}

double integrated_drift(const WalkerSetting& setting, double tolerance = IntegratedWalker::usual_tolerance) {
    IntegratedWalker walker{setting, 0, tolerance};
    return settle(walker).v_D;
}

double velocity_scale(const WalkerSetting& s) {
    return (std::abs(s.base.at(1)) + std::abs(s.base.at(2))) / two_pi / 20;
}

/// Amplitude (mm/s) and Theta of v_D = v* cos(phi - Theta), fitted to six phases over half a turn.
struct Fit {
    double mm_per_s;
    double theta;
};
Fit cosine_fit(const Friction& friction, double gamma_in_g) {
    std::complex<double> sum = 0;
    for (int i = 0; i < 6; ++i) {
        WalkerSetting s = paper_setting(gamma_in_g, pi * i / 6);
        s.friction = friction;
        sum += settle(s).v_D * std::polar(1.0, pi * i / 6) / 3.0;
    }
    return {1e3 * std::abs(sum), std::arg(sum)};
}

TEST(FrictionLawTest, IntegratorAgreesWithClosedForm) {
    std::mt19937_64 random{3};
    for (int i = 0; i < 12; ++i) {
        WalkerSetting s = paper_setting(std::exp(uniform(random, -1, 1.5)), uniform(random, -pi, pi));
        s.friction.viscous = i % 2 == 0 ? 0 : uniform(random, 0, 20);
        s.friction.backward = i % 3 == 0 ? 1 : uniform(random, 0.7, 1.4);
        s.friction.mu_s *= i % 4 == 0 ? 1.2 : 1;
        s.tilt = i % 5 == 0 ? 0.01 : 0;
        s.vertical.at(1) = i % 6 == 0 ? 1.5 : 0;
        const WalkerLaw law{s};
        Walker exact{law};
        IntegratedWalker walker{s};
        for (int k = 0; k < 5; ++k) {
            EXPECT_NEAR(walker.advance_period(), exact.advance_period(), 1e-8 * law.velocity_scale() / 20)
                << i;
            ASSERT_EQ(walker.events().size(), exact.events().size()) << i;
            for (std::size_t e = 0; e < exact.events().size(); ++e) {
                EXPECT_NEAR(walker.events()[e].phase, exact.events()[e].phase, 1e-6);
                EXPECT_EQ(walker.events()[e].to, exact.events()[e].to);
            }
        }
        EXPECT_NEAR(walker.now().v, exact.now().v, 1e-8 * law.velocity_scale());
    }
}

TEST(FrictionLawTest, PhasePlusHalfTurnFlipsDrift) {
    for (const FrictionLaw law : laws)
        for (const double phi : {0.0, 0.7, 2.2}) {
            const WalkerSetting s = with(law, 1.3, phi), mirrored = with(law, 1.3, phi + pi);
            EXPECT_NEAR(integrated_drift(s), -integrated_drift(mirrored), 2e-7 * velocity_scale(s))
                << friction_laws[static_cast<std::size_t>(law)] << " at phi " << phi;
        }
}

TEST(FrictionLawTest, OneHarmonicGivesNoDrift) {
    for (const FrictionLaw law : laws) {
        WalkerSetting s = with(law, 1, 0);
        s.base.at(2) = 0;
        EXPECT_NEAR(integrated_drift(s), 0, 2e-7 * velocity_scale(s));
    }
}

// The quick way to the cycle, also from the start of a nearby one, ends where the slow one does; and what it
// observes is the motion.
TEST(FrictionLawTest, QuickSettlingFindsTheSameCycle) {
    std::mt19937_64 random{11};
    for (const FrictionLaw law : laws) {
        if (law == FrictionLaw::lugre) continue;
        WarmStart start;
        for (int i = 0; i < 6; ++i) {
            WalkerSetting s = with(law, 0.6 + 0.05 * i, 0.3 * i);
            s.friction.mu_s = 1.1 * s.friction.mu_k;
            s.friction.viscous = uniform(random, 0, 5);
            IntegratedWalker quick{s}, slow{s};
            quick.observe(64);
            const SteadyState cycle = settle_quickly(quick, start);
            EXPECT_NEAR(cycle.v_D, settle(slow).v_D, 1e-7 * velocity_scale(s))
                << friction_laws[static_cast<std::size_t>(law)] << ", set-point " << i;
            double mean = 0;
            for (const double v : quick.relative()) mean += v / 64;
            EXPECT_NEAR(mean, cycle.v_D, 2e-2 * velocity_scale(s));
        }
    }
}

TEST(FrictionLawTest, ErrorFollowsTolerance) {
    for (const FrictionLaw law : laws) {
        const WalkerSetting s = with(law, 2, pi / 2);
        const double right = integrated_drift(s, 1e-12), V = velocity_scale(s);
        EXPECT_LT(std::abs(integrated_drift(s, 1e-5) - right), 3e-3 * V);
        EXPECT_LT(std::abs(integrated_drift(s, 1e-8) - right), 1e-5 * V);
        EXPECT_LT(std::abs(integrated_drift(s, 1e-10) - right), 1e-6 * V);
    }
}

TEST(FrictionLawTest, LawsTendToCoulombsLaw) {
    const double coulomb = settle(paper_setting(1, 0.5)).v_D;
    const auto off = [&](const auto& change) {
        WalkerSetting s = paper_setting(1, 0.5);
        change(s.friction);
        return std::abs(settle(s).v_D - coulomb) / velocity_scale(s);
    };
    const auto dahl = [&](double length) {
        return off([&](Friction& f) { f.law = FrictionLaw::dahl, f.presliding = length; });
    };
    EXPECT_GT(dahl(8e-6), 1e-3);
    EXPECT_LT(dahl(5e-7), 0.2 * dahl(8e-6));
    // A bristle swings with sqrt(mu g s_0) = 0.2 mm/s, 2e-3 of gamma/omega, while Coulomb's walker sticks.
    EXPECT_LT(dahl(3e-8), 1e-3);
    const auto lugre = [&](double length) {
        return off(
            [&](Friction& f) { f.law = FrictionLaw::lugre, f.presliding = length, f.bristle_time = 0; });
    };
    EXPECT_LT(lugre(5e-7), 0.2 * lugre(8e-6));
    const auto logarithmic = [&](double share) {
        return off([&](Friction& f) { f.law = FrictionLaw::logarithmic, f.log_share = share; });
    };
    EXPECT_NEAR(logarithmic(1e-3) / logarithmic(1e-4), 10, 0.1);  // linear
    EXPECT_LT(logarithmic(0), 1e-7);
}

TEST(FrictionLawTest, LuGreWithoutDampingIsDahl) {
    WalkerSetting s = with(FrictionLaw::dahl, 1, 0.5);
    const double dahl = settle(s).v_D;
    s.friction.law = FrictionLaw::lugre;
    s.friction.bristle_time = 0;  // and mu_s = mu_k: no Stribeck curve
    EXPECT_NEAR(settle(s).v_D, dahl, 1e-6 * velocity_scale(s));
}

// Amplitude in mm/s and Theta at 1 g and 3 g, as fitted to the same models by an independent program. Its
// Coulomb friction was smoothed over 0.3 mm/s in the rows with viscous friction alone, which shifts Theta.
TEST(FrictionLawTest, ModelsHaveAmplitudesOfTable) {
    const auto expect = [](const Friction& friction, double gamma_in_g, double mm_per_s, double theta) {
        const Fit fit = cosine_fit(friction, gamma_in_g);
        EXPECT_NEAR(fit.mm_per_s, mm_per_s, 0.15) << gamma_in_g << " g";
        EXPECT_NEAR(fit.theta, theta, 0.03) << gamma_in_g << " g";
    };
    const Friction coulomb{}, viscous{.viscous = 3.5};
    expect(coulomb, 1, 17.4, 0.59);
    expect(coulomb, 3, 57.0, 0.21);
    expect(viscous, 1, 15.8, 0.61);
    expect(viscous, 3, 38.2, 0.27);
    Friction dahl{.mu_k = 0.148, .mu_s = 0.148};
    dahl.law = FrictionLaw::dahl;
    dahl.presliding = 6.5e-6;
    expect(dahl, 1, 18.2, 0.67);
    expect(dahl, 3, 57.9, 0.22);
    dahl.mu_k = dahl.mu_s = 0.143;
    dahl.presliding = 7.2e-6;
    dahl.viscous = 4.2;
    expect(dahl, 1, 16.6, 0.69);
    expect(dahl, 3, 38.6, 0.25);
}

TEST(FrictionLawTest, SlipperyDirectionWins) {
    WalkerSetting s = paper_setting(1, 0);
    s.base.at(2) = 0;  // a symmetric drive: only friction has a direction
    s.friction.backward = 0.8;
    EXPECT_LT(settle(s).v_D, -1e-3);
    s.friction.backward = 1.25;
    EXPECT_GT(settle(s).v_D, 1e-3);
}

TEST(FrictionLawTest, MirroredDirectionsMirrorDrift) {
    for (const FrictionLaw law : {FrictionLaw::coulomb, FrictionLaw::dahl}) {
        WalkerSetting s = with(law, 1.2, 0.4), mirrored = with(law, 1.2, 0.4 + pi);
        s.friction.backward = 1.25;
        mirrored.friction.mu_k = mirrored.friction.mu_s = 1.25 * 0.113;
        mirrored.friction.backward = 0.8;
        EXPECT_NEAR(settle(s).v_D, -settle(mirrored).v_D, 1e-6 * velocity_scale(s));
    }
}

TEST(FrictionLawTest, AgeingDelaysRelease) {
    WalkerSetting s = paper_setting(0.5, 0);
    const SteadyState fresh = settle(s);
    s.friction.ageing = 0.05;
    s.friction.ageing_s = 1e-3;
    const SteadyState aged = settle(s);
    ASSERT_EQ(aged.rest.size(), 1U);
    EXPECT_GT(aged.rest[0].to, fresh.rest[0].to + 1e-4);
    // At the release |a_B| is mu_s g with the age of the stick.
    const double rest_s = (aged.rest[0].to - aged.rest[0].from) / 20;
    const double mu = 0.113 * (1 + 0.05 * std::log1p(rest_s / 1e-3));
    EXPECT_NEAR(std::abs(value_at(s.base, two_pi * aged.rest[0].to)), mu * s.g, 1e-9);
    s.friction.ageing_s = 1e3;  // nothing ages in a period
    EXPECT_NEAR(settle(s).v_D, fresh.v_D, 1e-6 * velocity_scale(s));
}

TEST(FrictionLawTest, StrengtheningSlowsFastWalker) {
    WalkerSetting s = with(FrictionLaw::logarithmic, 3, 0);
    s.friction.log_share = 0;
    const double plain = settle(s).v_D;
    s.friction.log_share = 0.1;
    const double strong = settle(s).v_D;
    EXPECT_LT(strong, 0.9 * plain);
    EXPECT_GT(strong, 0.3 * plain);
}

TEST(FrictionLawTest, OnlyClosedFormHasExactWalker) {
    WalkerSetting s = with(FrictionLaw::dahl, 1, 0);
    EXPECT_THROW(WalkerLaw{s}, InputError);
    s.friction = {};
    s.friction.roughness.share = 0.1;
    EXPECT_THROW(WalkerLaw{s}, InputError);
    EXPECT_THROW(settle(s), InputError);
    s.friction = {};
    s.friction.change.jitter = 0.02;
    EXPECT_NO_THROW(WalkerLaw{s});
    EXPECT_THROW(settle(s), InputError);
}

TEST(FrictionLawTest, ParametersOutOfRangeAreRefused) {
    const auto refused = [](auto change) {
        WalkerSetting s = paper_setting(1, 0);
        change(s.friction);
        EXPECT_THROW(checked(s), InputError);
    };
    refused([](Friction& f) { f.backward = 0; });
    refused([](Friction& f) { f.log_share = -1; });
    refused([](Friction& f) { f.presliding = 0; });
    refused([](Friction& f) { f.stribeck = NAN; });
    refused([](Friction& f) { f.bristle_time = -1; });
    refused([](Friction& f) { f.ageing = 2; });
    refused([](Friction& f) { f.ageing_s = 0; });
    refused([](Friction& f) { f.roughness.share = 0.3; });
    refused([](Friction& f) { f.change.memory = 1; });
    refused([](Friction& f) { f.change.jitter = 0.5; });
    refused([](Friction& f) { f.change.relaxation = -1; });
    refused([](Friction& f) { f.law = FrictionLaw::dahl, f.mu_k = 0; });
    refused([](Friction& f) { f.law = FrictionLaw::lugre, f.ageing = 0.1; });
    EXPECT_THROW((IntegratedWalker{paper_setting(1, 0), 0, 0}), InputError);
}

}  // namespace
}  // namespace shaker::walker

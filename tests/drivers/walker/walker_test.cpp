#include "drivers/walker/walker.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "drivers/errors.hpp"
#include "drivers/walker/steady_state.hpp"
#include "tests/support/no_alloc.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/walker/scenes.hpp"

namespace shaker::walker {
namespace {

constexpr double pi = std::numbers::pi;

Harmonics<Acceleration> harmonics_of(const nlohmann::json& list) {
    Harmonics<Acceleration> h;
    for (const auto& term : list) {
        h.at(term.at("q")) += std::polar(term.at("a").get<double>(), term.at("phase").get<double>());
    }
    return h;
}

TEST(WalkerTest, EveryReferenceCaseHoldsToRounding) {
    const auto file =
        nlohmann::json::parse(std::ifstream{test::source_dir() + "/tests/golden/physics_reference.json"});
    int cases = 0;
    for (const auto& c : file.at("cases")) {
        SCOPED_TRACE(c.at("name"));
        const auto &p = c.at("params"), &answer = c.at("answer");
        const WalkerLaw law{{.frequency = p.at("f_hz"),
                             .base = harmonics_of(p.at("base_accel")),
                             .vertical = harmonics_of(p.at("vertical_accel")),
                             .tilt = p.at("tilt_deg").get<double>() * pi / 180,
                             .g = p.at("g"),
                             .friction = {p.at("mu_k"), p.at("mu_s"), 0}}};
        const double V = law.velocity_scale(), tolerance = 1e-13 * V;  // a thousandth of what is asked for
        const SteadyState s = settle(law);
        EXPECT_NEAR(s.v_D, answer.at("v_D"), tolerance);
        EXPECT_NEAR(s.v0, answer.at("v_at_t0"), tolerance);
        EXPECT_EQ(static_cast<int>(s.contact0), answer.at("state_at_t0"));
        EXPECT_NEAR(s.rest_fraction, answer.at("stick_fraction"), 1e-12);  // printed to 12 digits
        EXPECT_NEAR(s.contraction, answer.at("contraction_per_period"), 1e-11);
        EXPECT_NEAR(static_cast<double>(s.periods), answer.at("periods_to_converge"), 1);  // rounding decides
        ASSERT_EQ(s.events.size(), answer.at("events").size());
        for (std::size_t i = 0; i < s.events.size(); ++i) {
            const auto& event = answer.at("events")[i];
            EXPECT_NEAR(s.events[i].phase, event[0], 1e-13);
            EXPECT_EQ(static_cast<int>(s.events[i].from), event[1]);
            EXPECT_EQ(static_cast<int>(s.events[i].to), event[2]);
        }
        Walker walker{law};
        for (const auto& D : answer.at("startup_D")) {
            EXPECT_NEAR(walker.advance_period(), D, tolerance * law.period());
        }
        ++cases;
    }
    EXPECT_EQ(cases, 13);
}

TEST(WalkerTest, MillionSettledPeriodsAreMillionTimesDrift) {
    const WalkerLaw law{paper_setting(2, pi / 2)};
    const SteadyState s = settle(law);
    Walker walker{law, s.v0};
    for (int k = 0; k < 1000000; ++k) walker.advance_period();
    EXPECT_EQ(walker.period(), 1000000);
    EXPECT_NEAR(walker.now().x / (1e6 * s.D), 1, 1e-10);
    EXPECT_NEAR(walker.now().v, s.v0, 1e-14);
}

TEST(WalkerTest, SteppingPeriodsDoesNotAllocate) {
    const WalkerLaw law{paper_setting(0.5, 0)};
    Walker walker{law};
    const test::NoAlloc guard;
    for (int k = 0; k < 20; ++k) {
        walker.advance_to(0.3);
        walker.advance_period();
    }
}

TEST(WalkerTest, IntermediatePointsDoNotChangePath) {
    std::mt19937_64 random{7};
    for (const WalkerSetting& setting : {scenes::threshold(), scenes::brief_stick(), paper_setting(3, 0)}) {
        const WalkerLaw law{setting};
        Walker straight{law}, watched{law};
        for (int k = 0; k < 50; ++k) {
            double phase = 0;
            for (int i = 0; i < 20; ++i) watched.advance_to(phase = uniform(random, phase, 1));
            EXPECT_EQ(straight.advance_period(), watched.advance_period());
            EXPECT_EQ(straight.now().v, watched.now().v);
            EXPECT_EQ(straight.events().size(), watched.events().size());
        }
    }
}

TEST(WalkerTest, VelocityIsDerivativeOfPosition) {
    WalkerSetting setting = paper_setting(1.5, 1.0);
    setting.vertical.at(1) = 2.0;
    setting.friction.viscous = 4;
    const WalkerLaw law{setting};
    Walker walker{law};
    constexpr int steps = 20000;
    const double h = law.period() / steps, most_acceleration = 3 * paper_g;
    WalkerPoint before = walker.now();
    for (int i = 1; i <= steps; ++i) {
        const WalkerPoint point = walker.advance_to(static_cast<double>(i) / steps);
        EXPECT_NEAR(point.v, before.v, most_acceleration * h);
        EXPECT_NEAR((point.x - before.x) / h, (point.v + before.v) / 2, most_acceleration * h / 4);
        before = point;
    }
}

TEST(WalkerTest, RefusesPastPhase) {
    const WalkerLaw law{paper_setting(1, 0)};
    Walker walker{law};
    walker.advance_to(0.5);
    EXPECT_THROW(walker.advance_to(0.4), std::invalid_argument);
    EXPECT_THROW(walker.advance_to(1.1), std::invalid_argument);
    EXPECT_NO_THROW(walker.advance_to(0.5));
}

TEST(WalkerTest, SlidingWalkerStopsAfterBrakingDistance) {
    WalkerSetting setting;
    const WalkerLaw law{setting};
    Walker walker{law, 0.5};
    double x = 0;
    for (int k = 0; k < 12; ++k) x += walker.advance_period();  // it takes 9.03 periods
    EXPECT_NEAR(x, 0.25 / (2 * 0.113 * paper_g), 1e-15);
    EXPECT_EQ(walker.now().v, 0);
    EXPECT_EQ(walker.now().contact, Contact::stick);
}

TEST(WalkerTest, LossOfContactNamesNormalForceAndPhase) {
    WalkerSetting setting = paper_setting(1, 0);
    setting.vertical.at(2) = 10.8;  // sin 2wt is -1 at 3/8 and 7/8 of the period, where n = 9.8 - 10.8
    try {
        const WalkerLaw law{setting};
        FAIL() << "a walker in the air was accepted";
    } catch (const InputError& error) {
        const std::string message = error.what();
        EXPECT_NE(message.find("falls to -1 m/s^2"), std::string::npos) << message;
        EXPECT_TRUE(message.find("0.375") != std::string::npos || message.find("0.875") != std::string::npos)
            << message;
    }
}

TEST(WalkerTest, SettingsOutOfRangeAreRefused) {
    const auto refused = [](auto change) {
        WalkerSetting setting = paper_setting(1, 0);
        change(setting);
        EXPECT_THROW(WalkerLaw{setting}, InputError);
    };
    refused([](WalkerSetting& s) { s.frequency = 0; });
    refused([](WalkerSetting& s) { s.frequency = NAN; });
    refused([](WalkerSetting& s) { s.g = -9.8; });
    refused([](WalkerSetting& s) { s.tilt = 2; });
    refused([](WalkerSetting& s) { s.friction.mu_k = -0.1; });
    refused([](WalkerSetting& s) { s.friction.mu_s = 0.1; });
    refused([](WalkerSetting& s) { s.friction.viscous = -1; });
    refused([](WalkerSetting& s) { s.friction.viscous = 1e6; });
    refused([](WalkerSetting& s) { s.base.at(3) = NAN; });
}

}  // namespace
}  // namespace shaker::walker

// mu from the measurements of a bench in use: by the law, with tilt from pairs, in a thread of its own or
// not.
#include "daemon/service/live_mu.hpp"

#include <gtest/gtest.h>

#include <numbers>
#include <thread>

namespace shaker::service {
namespace {

constexpr double pi = std::numbers::pi;

/// A measurement of a walker by this law. viscous: v_D is lower by this share of gamma/omega.
reduction::Reduction measured(const Drive& drive, const law::Coulomb& truth, double viscous = 0) {
    reduction::Reduction r;
    r.frequency = {drive.frequency, 1e-6};
    const Harmonics<Acceleration> base = harmonics(drive);
    for (int q = 1; q <= 2; ++q)
        r.harmonics.push_back(
            {.q = q, .amplitude = {std::abs(base.at(q)), 1e-4}, .phase = {std::arg(base.at(q)), 1e-5}});
    law::Point p;
    p.base = base;
    p.frequency = drive.frequency;
    r.v_D = {law_point(p, truth).v_D - viscous * drive.gamma / (two_pi * drive.frequency), 3e-6};
    r.periods.resize(40);
    return r;
}

TEST(LiveMuTest, IsKnownFromThreePoints) {
    for (const bool beside : {false, true}) {
        LiveMu live{paper_g, beside};
        const law::Coulomb truth{.mu = 0.13};
        for (const double phi : {0.0, 1.0, 2.5}) {
            EXPECT_FALSE(std::isfinite(live.mu().value));
            const Drive drive{.gamma = paper_g, .phi = phi};
            live.add(measured(drive, truth), drive);
            while (!live.follow()) std::this_thread::yield();
        }
        EXPECT_NEAR(live.mu().value, 0.13, 4 * live.mu().error);
        EXPECT_LT(live.mu().error, 1e-3);
        EXPECT_FALSE(live.follow()) << "nothing is new";
    }
}

TEST(LiveMuTest, MirrorPartnersTakeTheTiltOut) {
    LiveMu live{paper_g, false};
    const law::Coulomb truth{.mu = 0.113, .tilt = 2e-3};
    for (const double phi : {0.2, 0.2 + pi, 2.5, 2.5 - pi}) {
        const Drive drive{.gamma = paper_g, .phi = phi};
        live.add(measured(drive, truth), drive);
        live.follow();
    }
    EXPECT_NEAR(live.mu().value, 0.113, 4 * live.mu().error);
}

TEST(LiveMuTest, NewestFortyCount) {
    LiveMu live{paper_g, false};
    for (int i = 0; i < 60; ++i) {
        const Drive drive{.gamma = paper_g, .phi = 0.05 * (i % 40)};
        live.add(measured(drive, {.mu = i < 20 ? 0.2 : 0.113}), drive);
    }
    live.follow();
    EXPECT_NEAR(live.mu().value, 0.113, 4 * live.mu().error);
    EXPECT_EQ(live.mu().points, 40);
}

TEST(LiveMuTest, ARefusedMuPredictsWithALargeError) {
    LiveMu live{paper_g, false};
    for (const double gamma : {0.7, 1.0, 1.5, 2.0, 3.0}) {
        const Drive drive{.gamma = gamma * paper_g};
        live.add(measured(drive, {.mu = 0.113}, 0.02), drive);
    }
    live.follow();
    ASSERT_TRUE(std::isfinite(live.mu().value));
    EXPECT_TRUE(live.mu().refused);
    EXPECT_GT(live.to_predict().sigma, 0.19 * live.mu().value);
    EXPECT_EQ(live.to_predict().value, live.mu().value);
}

}  // namespace
}  // namespace shaker::service

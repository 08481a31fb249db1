#include "daemon/law/slope_mu.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "drivers/walker/steady_state.hpp"
#include "tests/support/law/synthetic_points.hpp"

namespace shaker::law {
namespace {

// A point with the exact cycle at 100 phases of a camera with 50 frames a period.
Point with_cycle(double gamma_in_g, double phi, const walker::Friction& friction, double tilt) {
    const Drive drive = test::drive_at(gamma_in_g, phi);
    walker::WalkerSetting setting;
    setting.base = harmonics(drive);
    setting.tilt = tilt;
    setting.friction = friction;
    const walker::WalkerLaw law{setting};
    const walker::SteadyState steady = walker::settle(law);
    Point p = test::exact_point(drive, {.mu = 0.113});
    p.v_D.value = steady.v_D;
    p.phases_per_period = 50;
    walker::Walker walker{law, steady.v0};
    for (int i = 0; i < 100; ++i) {
        const walker::WalkerPoint at = walker.advance_to(i / 100.0);
        p.cycle.phase.push_back(i / 100.0);
        p.cycle.x_m.push_back(at.x);
        p.cycle.x_sd_m.push_back(3e-7);
        p.cycle.v_mps.push_back(at.v);
        p.cycle.v_sd_mps.push_back(1e-4);
        p.cycle.v_base_mps.push_back(law.v_base(two_pi * i / 100.0));
    }
    for (const auto& r : steady.rest) p.stick.push_back({r.from, r.to, 0.01});
    return p;
}

std::vector<Point> cycles(const walker::Friction& friction, double tilt = 0) {
    std::vector<Point> points;
    for (const auto& [gamma, phi] : {std::pair{0.5, 0.0}, {1.0, 0.0}, {2.0, 1.57}, {1.0, 2.2}, {3.0, 4.0}})
        points.push_back(with_cycle(gamma, phi, friction, tilt));
    return points;
}

TEST(SlopeFitTest, RecoversMuAndTiltOfExactCycles) {
    const SlopeFit fit = fit_slopes(cycles({0.113, 0.113}, 1e-3));
    EXPECT_NEAR(fit.mu.value, 0.113, 1e-6);
    EXPECT_NEAR(fit.tilt.value, 1e-3, 1e-6);
    EXPECT_GE(fit.mu.points, 7);
    EXPECT_LT(fit.mu.error, 2e-3);
    EXPECT_EQ(fit.mu.note, "");
    EXPECT_NEAR(fit.viscous.value, 0, 1e-3);
}

TEST(SlopeFitTest, StaticFrictionDoesNotMatter) {
    EXPECT_NEAR(fit_slopes(cycles({0.113, 0.15})).mu.value, 0.113, 1e-6);
}

TEST(SlopeFitTest, ViscousFrictionIsMeasuredAndStated) {
    std::vector<Point> points = cycles({0.113, 0.113, 3.5});
    for (Point& p : points)
        for (double& sd : p.cycle.x_sd_m) sd = 2e-8;
    const SlopeFit fit = fit_slopes(points);
    EXPECT_NEAR(fit.viscous.value, 3.5, 0.05);
    EXPECT_NE(fit.viscous.note.find("depends on the velocity"), std::string::npos);
}

// mu(v_R) is mu + c |v_R|/g of the friction, in both directions; unequal directions are seen.
TEST(SlopeFitTest, FrictionByVelocityIsThatOfTheLaw) {
    std::vector<Point> points;
    for (const double gamma : {1.0, 1.5, 2.0, 3.0})
        for (const double phi : {0.0, 1.0, 2.2, 3.14, 4.1, 5.3})
            points.push_back(with_cycle(
                gamma, phi, {.mu_k = 0.113, .mu_s = 0.113, .viscous = 3.5, .backward = 1.1}, 1e-3));
    const auto found = friction_by_velocity(points, paper_g, {1e-3, 1e-6}, "by gravity").at;
    ASSERT_GE(found.size(), 8U);
    EXPECT_LT(found.front().v_R, -0.1);
    EXPECT_GT(found.back().v_R, 0.1);
    for (const FrictionAt& f : found) {
        const double mu = 0.113 * (f.v_R < 0 ? 1.1 : 1) + 3.5 * std::abs(f.v_R) / paper_g;
        EXPECT_NEAR(f.mu.value, mu, 2e-2 * mu) << f.v_R;
    }
    EXPECT_TRUE(friction_by_velocity({}, paper_g, {0, 0}, "").at.empty());
}

// In a table of version 1, v(t) is smoothed across kinks: parts keep a larger distance from them.
TEST(SlopeFitTest, PartsKeepTheirDistanceFromKinks) {
    Point p = with_cycle(2.0, 1.57, {0.113, 0.113}, 0);
    const auto nearest = [&] {
        double least = 1;
        for (const SlipForce& f : slip_forces(p))
            for (const std::size_t at : {f.from, f.to})
                for (std::size_t i = 0; i < 100; ++i) {
                    const double here = p.cycle.v_mps[i] - p.cycle.v_base_mps[i],
                                 next = p.cycle.v_mps[(i + 1) % 100] - p.cycle.v_base_mps[(i + 1) % 100];
                    if ((here > 0) != (next > 0))
                        least = std::min(
                            least,
                            std::abs(std::remainder(
                                static_cast<double>(at) / 100 - (static_cast<double>(i) + 0.5) / 100, 1.0)));
                }
        return 50 * least;  // frames
    };
    EXPECT_GT(nearest(), 0.7);
    EXPECT_LT(nearest(), 1.5);
    p.kink_frames = smoothed_frames;
    EXPECT_GT(nearest(), 4.2);
    EXPECT_FALSE(slip_forces(p).empty());
}

// Where no tilt with an error is given, that of the slips is taken; its error is in each mu.
TEST(SlopeFitTest, FrictionByVelocityTakesTheTiltOfTheSlips) {
    const std::vector<Point> points = cycles({0.113, 0.113}, 5e-3);
    const Friction found = friction_by_velocity(points, paper_g, {0.1, NAN}, "by gravity");
    EXPECT_NEAR(found.tilt.value, 5e-3, 1e-4);
    EXPECT_NE(found.tilt_from.find("by the slips"), std::string::npos);
    for (const FrictionAt& f : found.at) {
        EXPECT_NEAR(f.mu.value, 0.113, 1e-3) << f.v_R;
        EXPECT_GE(f.mu.sigma, found.tilt.sigma);
    }
    const Friction given = friction_by_velocity(points, paper_g, {5e-3, 2e-3}, "by gravity");
    EXPECT_EQ(given.tilt_from, "by gravity");
    EXPECT_GE(given.at.front().mu.sigma, 2e-3);
}

// A walker at rest whose stick was not found: noise gives v_R signs, and the base's acceleration is no
// friction.
TEST(SlopeFitTest, RestIsNoSlip) {
    std::mt19937_64 random{5};
    std::normal_distribution<double> noise{0, 4e-5};
    Point p = with_cycle(0.1, 1.57, {0.113, 0.113}, 0);
    for (double& v : p.cycle.v_mps) v += noise(random);
    for (double& sd : p.cycle.v_sd_mps) sd = 4e-5;
    p.stick.clear();
    EXPECT_TRUE(slip_forces(p).empty());
    for (double& v : p.cycle.v_mps) v += 2e-5;  // rest between two zeros that are far apart
    EXPECT_TRUE(slip_forces(p).empty());
}

// Phases that no frame shows are not bridged.
TEST(SlopeFitTest, PartsDoNotBridgeMissingPhases) {
    Point p = with_cycle(2.0, 1.57, {0.113, 0.113}, 0);
    const std::size_t before = slip_forces(p).size();
    const SlipForce lost = slip_forces(p).front();
    for (auto* column : {&p.cycle.phase, &p.cycle.x_m, &p.cycle.x_sd_m, &p.cycle.v_mps, &p.cycle.v_sd_mps,
                         &p.cycle.v_base_mps})
        column->erase(
            column->begin() + static_cast<std::ptrdiff_t>(lost.from % 100),
            column->begin() + static_cast<std::ptrdiff_t>(std::min<std::size_t>(lost.from % 100 + 9, 99)));
    EXPECT_LT(slip_forces(p).size(), before);
    for (const SlipForce& f : slip_forces(p))
        EXPECT_NEAR(std::abs(f.a.value), 0.113 * paper_g, 0.02 * paper_g) << f.from << " " << f.to;
}

TEST(SlopeFitTest, SlowCamerasGiveNoSlopes) {
    std::vector<Point> points = cycles({0.113, 0.113});
    for (Point& p : points) p.phases_per_period = 10;
    const SlopeFit fit = fit_slopes(points);
    EXPECT_TRUE(std::isnan(fit.mu.value));
    EXPECT_NE(fit.mu.note.find("frames"), std::string::npos);
    EXPECT_TRUE(std::isnan(fit_slopes({}).mu.value));
}

}  // namespace
}  // namespace shaker::law

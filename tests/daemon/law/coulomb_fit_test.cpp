#include "daemon/law/coulomb_fit.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "daemon/law/findings.hpp"
#include "drivers/walker/steady_state.hpp"
#include "tests/support/law/stepped_walker.hpp"
#include "tests/support/law/synthetic_points.hpp"

namespace shaker::law {
namespace {

using test::add_noise;
using test::exact_points;

TEST(CoulombFitTest, RecoversTheLawOfExactPoints) {
    for (const double mu : {0.07, 0.113, 0.2}) {
        const CoulombFit fit = fit_coulomb(exact_points({.mu = mu, .push = 0.1}));
        EXPECT_NEAR(fit.mu.value, mu, 1e-5 * mu);
        EXPECT_NEAR(fit.push.value, 0.1, 1e-5);
        EXPECT_NEAR(fit.tilt.value, 0, 1e-7);
        EXPECT_EQ(fit.mu.note, "");
        EXPECT_LT(fit.mu.chi2, 0.01);
        EXPECT_EQ(fit.mu.freedom, 10);
    }
}

TEST(CoulombFitTest, RecoversTheTiltOfMirrorPartners) {
    const CoulombFit fit = fit_coulomb(exact_points({.mu = 0.113, .tilt = 1e-3, .push = 0.1}));
    EXPECT_NEAR(fit.tilt.value, 1e-3, 1e-7);
    EXPECT_LT(fit.tilt.error, 1e-5);
    EXPECT_NEAR(fit.mu.value, 0.113, 1e-6);
    EXPECT_EQ(fit.covariance.values.size(), 4U);
}

TEST(CoulombFitTest, TiltIsNotFittedWithoutPartners) {
    std::vector<Point> points = exact_points({.mu = 0.113});
    for (Point& p : points) p.partner = 0;
    const CoulombFit fit = fit_coulomb(points);
    EXPECT_TRUE(std::isnan(fit.tilt.value));
    EXPECT_NE(fit.tilt.note.find("mirror partners"), std::string::npos);
    EXPECT_NEAR(fit.mu.value, 0.113, 1e-6);
}

TEST(CoulombFitTest, PushLeftOutIsSeen) {
    const CoulombFit fit = fit_coulomb(exact_points({.mu = 0.113, .push = 0.1}));
    EXPECT_GT(fit.chi2_without_push, 20);
    EXPECT_EQ(fit.beyond_3, 0);
}

TEST(CoulombFitTest, TooFewPointsThatMoveAreRefused) {
    std::vector<Point> points{test::exact_point(test::drive_at(0.1, 0), {.mu = 0.113}),
                              test::exact_point(test::drive_at(1, 0), {.mu = 0.113})};
    const CoulombFit fit = fit_coulomb(points);
    EXPECT_FALSE(fit.known());
    EXPECT_EQ(fit.mu.note, "1 of 2 points move; at least 3 are needed");
    EXPECT_FALSE(fit_coulomb({}).known());
}

TEST(CoulombFitTest, OtherFrictionIsStatedAsMisfit) {
    std::vector<Point> points = exact_points({.mu = 0.113});
    for (Point& p : points) {
        walker::WalkerSetting s;
        s.base = p.base;
        s.friction = {0.113, 0.113, 3.5};
        p.v_D.value = walker::settle(s).v_D;
    }
    const CoulombFit fit = fit_coulomb(points);
    EXPECT_NE(fit.mu.note.find("does not describe the points"), std::string::npos);
    EXPECT_GT(fit.beyond_3, 6);
}

// A walker under another law, for which no mu of Coulomb's converges, still has a name, a reason and its
// cycles.
TEST(CoulombFitTest, FitWithoutEndIsRefusedByName) {
    LawSetting viscous;
    viscous.friction.viscous = 30;
    viscous.push = 0.1;
    const CoulombFit fit = fit_coulomb(test::stepped_points(viscous, 4000));
    EXPECT_EQ(fit.mu.name, "mu_ac");
    EXPECT_EQ(fit.tilt.name, "tilt");
    EXPECT_TRUE(fit.mu.refused);
    EXPECT_NE(fit.mu.note, "");
    EXPECT_EQ(fit.points.size(), 12U);
}

// Mean and scatter of z over 200 campaigns: the errors are those of the noise.
TEST(CoulombFitTest, ErrorsOfMuAndTiltCover) {
    const std::vector<Point> exact = exact_points({.mu = 0.113, .tilt = 3e-4, .push = 0.1});
    std::mt19937_64 random{5};
    constexpr int campaigns = 200;
    double sum = 0, squares = 0, tilt_squares = 0;
    int within = 0;
    for (int i = 0; i < campaigns; ++i) {
        std::vector<Point> points = exact;
        add_noise(points, random);
        const CoulombFit fit = fit_coulomb(points, {.start_mu = 0.115});
        const double z = (fit.mu.value - 0.113) / fit.mu.error;
        sum += z;
        squares += z * z;
        within += std::abs(z) < 2;
        tilt_squares += std::pow((fit.tilt.value - 3e-4) / fit.tilt.error, 2);
    }
    EXPECT_LT(std::abs(sum / campaigns), 4 / std::sqrt(campaigns));
    EXPECT_NEAR(std::sqrt(squares / campaigns), 1, 0.2);
    EXPECT_NEAR(std::sqrt(tilt_squares / campaigns), 1, 0.2);
    EXPECT_GE(within, campaigns * 91 / 100);
}

/// As an accelerometer's corner turns them; a told corner turns all points alike.
void turn(Point& p, double phi) {
    for (int q = 1; q <= max_harmonics; ++q) p.base.at(q) *= std::polar(1.0, phi * (q - 1.0 / q) / 1.5);
}

TEST(LawPointTest, ATurnOfTheHarmonicsMovesTheLaw) {
    for (Point p : exact_points({.mu = 0.113, .push = 0.1})) {
        const Coulomb law{.mu = 0.113, .push = 0.1};
        const LawPoint at = law_point(p, law);
        constexpr double small = 1e-4;
        Point there = p, back = p;
        turn(there, small);
        turn(back, -small);
        const double by_turn = (law_point(there, law).v_D - law_point(back, law).v_D) / (2 * small);
        EXPECT_NEAR(at.by_turn, by_turn, 1e-3 * velocity_scale(p)) << p.number;
        p.turn_sd = 3e-3;
        p.turn_told = 4e-3;
        EXPECT_NEAR(law_point(p, law).base_error, std::hypot(at.base_error, 5e-3 * by_turn),
                    1e-3 * at.base_error + 1e-5 * velocity_scale(p));
    }
}

TEST(PointTest, PhasesThatAreWorseThanTheNoiseAreATurn) {
    Point p;
    EXPECT_TRUE(p.take({.q = 1, .amplitude = {5, 1e-3}, .phase = {0, 0}}));
    EXPECT_TRUE(p.take({.q = 2, .amplitude = {5, 1e-3}, .phase = {0.1, 4.5e-4}}));
    EXPECT_EQ(p.turn_sd, 0) << "the noise of both harmonics";
    EXPECT_TRUE(p.take({.q = 2, .amplitude = {5, 1e-3}, .phase = {0.1, 2e-3}}));
    EXPECT_NEAR(p.turn_sd, std::sqrt(4e-6 - 5 * 4e-8), 1e-9);
    EXPECT_FALSE(p.take({.q = max_harmonics + 1, .amplitude = {1, 1}, .phase = {0, 0}}));
}

TEST(BudgetTest, ATurnOfAllPointsIsASourceOfItsOwn) {
    std::vector<Point> points = exact_points({.mu = 0.113, .push = 0.1});
    const double mu = fit_coulomb(points).mu.value;
    for (Point& p : points) p.turn_told = 1e-3;
    const CoulombFit fit = fit_coulomb(points);
    const Budget budget = coulomb_budget(points, fit, {});
    const auto share = std::ranges::find(budget.shares, "corner", &Share::source);
    ASSERT_NE(share, budget.shares.end());
    for (Point& p : points) turn(p, 1e-3);
    EXPECT_NEAR(share->share, std::abs(fit_coulomb(points).mu.value / mu - 1), 0.05 * share->share);
}

TEST(BudgetTest, SharesAreSortedAndPredictTheShift) {
    std::vector<Point> points = exact_points({.mu = 0.113, .push = 0.1});
    const CoulombFit fit = fit_coulomb(points);
    const Budget budget = coulomb_budget(points, fit, {.gain = 1e-3});
    ASSERT_EQ(budget.shares.size(), 7U);
    for (std::size_t i = 1; i < budget.shares.size(); ++i)
        EXPECT_GE(budget.shares[i - 1].share, budget.shares[i].share);
    for (Point& p : points)
        for (auto& a : p.base.a) a *= 1.001;
    const double shifted = fit_coulomb(points).mu.value / fit.mu.value - 1;
    for (const Share& s : budget.shares) {
        if (s.source != "gain") continue;
        EXPECT_NEAR(s.share, std::abs(shifted), 0.05 * std::abs(shifted));
    }
}

TEST(BudgetTest, NothingForAMuThatIsNotKnown) {
    EXPECT_TRUE(coulomb_budget({}, fit_coulomb({}), {}).shares.empty());
    EXPECT_TRUE(slope_budget(fit_slopes({}), {}).shares.empty());
}

}  // namespace
}  // namespace shaker::law

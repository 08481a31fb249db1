#include "daemon/law/phase_fits.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <numbers>
#include <random>

#include "daemon/law/slope_mu.hpp"
#include "drivers/walker/no_stick.hpp"
#include "tests/support/law/synthetic_points.hpp"

namespace shaker::law {
namespace {

using std::numbers::pi;
using test::drive_at;
using test::exact_point;

constexpr Coulomb level{.mu = 0.113};

std::vector<Point> around(double gamma_in_g, double center, const Coulomb& law) {
    std::vector<Point> points;
    for (const double off : {-0.25, -0.15, -0.05, 0.05, 0.15, 0.25})
        for (const double turn : {0.0, pi})
            points.push_back(exact_point(drive_at(gamma_in_g, center + off + turn), law));
    return points;
}

TEST(CosineFitTest, RecoversACosine) {
    std::vector<Point> points;
    for (int k = 0; k < 6; ++k) {
        Point p = exact_point(drive_at(1, k * pi / 3), level);
        p.v_D.value = 0.0176 * std::cos(p.phi.value - 0.62);
        points.push_back(p);
    }
    const auto fits = cosine_fits(points);
    ASSERT_EQ(fits.size(), 1U);
    EXPECT_NEAR(fits[0].amplitude.value, 0.0176, 1e-12);
    EXPECT_NEAR(fits[0].theta.value, 0.62, 1e-10);
    const double of_each = std::hypot(1e-6 / 0.0176, phi_error(points[0]));
    EXPECT_NEAR(fits[0].theta.error, of_each * std::sqrt(2.0 / 6), 0.3 * of_each);
    EXPECT_EQ(fits[0].amplitude.note, "");
}

TEST(CosineFitTest, DoesNotMixFrequencies) {
    std::vector<Point> points;
    for (int k = 0; k < 9; ++k) {
        Point p = exact_point(drive_at(1, k * pi / 3), level);
        p.v_D.value = (k < 6 ? 0.0176 : 0.01) * std::cos(p.phi.value - 0.62);
        p.asked.frequency = k < 6 ? 20 : 35;
        points.push_back(p);
    }
    const auto fits = cosine_fits(points);
    ASSERT_EQ(fits.size(), 1U);
    EXPECT_EQ(fits[0].amplitude.points, 6);
    EXPECT_NEAR(fits[0].amplitude.value, 0.0176, 1e-12);
}

TEST(CosineFitTest, CoulombDriftIsStatedAsMisfit) {
    std::vector<Point> points;
    for (int k = 0; k < 12; ++k) points.push_back(exact_point(drive_at(0.68, k * pi / 6), level));
    const auto fits = cosine_fits(points);
    ASSERT_EQ(fits.size(), 1U);
    EXPECT_NEAR(fits[0].theta.value, 0.83, 0.01);
    EXPECT_NE(fits[0].amplitude.note.find("not a cosine"), std::string::npos);
}

// Two series of one gamma differ by what the cosine misses at their phases.
TEST(CosineFitTest, ErrorCoversTheChoiceOfPhases) {
    std::vector<Point> around_once;
    around_once.reserve(60);
    for (int k = 0; k < 60; ++k) around_once.push_back(exact_point(drive_at(1, k * pi / 30), level));
    const auto whole = cosine_fits(around_once);
    ASSERT_EQ(whole.size(), 1U);
    std::mt19937 draw{5};
    int fitted = 0, covered = 0;
    double squares = 0;
    for (int set = 0; set < 300; ++set) {
        std::vector<Point> some;
        std::ranges::sample(around_once, std::back_inserter(some), 12, draw);
        const auto fits = cosine_fits(some);
        if (fits.empty()) continue;  // a gap in the phases
        for (const auto& [one, all] :
             {std::pair{fits[0].amplitude, whole[0].amplitude}, std::pair{fits[0].theta, whole[0].theta}}) {
            const double z = (one.value - all.value) / one.error;
            ++fitted;
            covered += std::abs(z) < 2;
            squares += z * z;
        }
    }
    std::printf("%d fits: %.1f %% within 2 errors, rms %.2f\n", fitted, 100.0 * covered / fitted,
                std::sqrt(squares / fitted));
    EXPECT_GT(fitted, 400);
    EXPECT_GT(covered, 0.93 * fitted);
    EXPECT_NEAR(std::sqrt(squares / fitted), 0.9, 0.3);
}

TEST(CosineFitTest, PhasesOfOneSideAreNotEnough) { EXPECT_TRUE(cosine_fits(around(1, 2.17, level)).empty()); }

TEST(NullPhaseTest, IsThatOfTheExactWalker) {
    for (const double gamma : {0.68, 1.0, 2.0, 3.0}) {
        const double theta = walker::coulomb_theta(gamma / 0.113);
        const auto fits = null_phases(around(gamma, theta + pi / 2 + 0.02, level));
        ASSERT_EQ(fits.size(), 1U);
        EXPECT_NEAR(fits[0].value - pi / 2, theta, 2e-4) << gamma;
        EXPECT_EQ(fits[0].points, 12);
    }
}

TEST(NullPhaseTest, TiltCancelsInMirrorPartners) {
    const auto level_null = null_phases(around(1, 2.17, level)),
               tilted = null_phases(around(1, 2.17, {.mu = 0.113, .tilt = 1e-3}));
    ASSERT_EQ(level_null.size(), 1U);
    ASSERT_EQ(tilted.size(), 1U);
    EXPECT_NEAR(tilted[0].value, level_null[0].value, 1e-4);
}

TEST(NullPhaseTest, NoNullWithoutAChangeOfSign) {
    std::vector<Point> points;
    for (const double phi : {1.6, 1.7, 1.8}) points.push_back(exact_point(drive_at(1, phi), level));
    EXPECT_TRUE(null_phases(points).empty());
}

TEST(ReversalTest, LawBetweenDistantPointsIsExact) {
    const double phi = 3 * pi / 4;
    std::vector<Point> coarse, fine;
    for (const double gamma : {0.5, 0.75, 1.0, 1.25})
        coarse.push_back(exact_point(drive_at(gamma, phi), level));
    for (const double gamma : {0.73, 0.735, 0.74, 0.745})
        fine.push_back(exact_point(drive_at(gamma, phi), level));
    const auto by_law = reversals(coarse, &level), near = reversals(fine), far = reversals(coarse);
    ASSERT_EQ(by_law.size(), 1U);
    ASSERT_EQ(near.size(), 1U);
    ASSERT_EQ(far.size(), 1U);
    EXPECT_NEAR(by_law[0].value, near[0].value, 1e-5 * paper_g);
    EXPECT_NEAR(far[0].value, near[0].value, 4 * far[0].error);
    EXPECT_EQ(by_law[0].note, "v_D becomes negative at larger gamma");
}

TEST(ThresholdTest, LiesBetweenRestAndMotion) {
    std::vector<Point> points;
    for (const double gamma : {0.1, 0.12, 0.14, 0.3}) {
        points.push_back(exact_point(drive_at(gamma, 0), level));
        if (gamma < 0.13) points.back().stick = {{0, 1, 0.01}};
    }
    points[2].v_D.value = 5e-6;
    const auto fits = thresholds(points);
    ASSERT_EQ(fits.size(), 1U);
    EXPECT_NEAR(fits[0].value, 0.13 * paper_g, 1e-3 * paper_g);  // 1.1362 mu_s g = 0.1284 g
    EXPECT_NEAR(fits[0].error, 0.01 / std::sqrt(3.0) * paper_g, 1e-3 * paper_g);
    EXPECT_NE(fits[0].note.find("mu_s = 0.114"), std::string::npos) << fits[0].note;
    points.erase(points.begin(), points.begin() + 2);
    EXPECT_TRUE(std::isnan(thresholds(points)[0].value));
    EXPECT_NE(thresholds(points)[0].note.find("lowest gamma is 0.14 g"), std::string::npos);
}

TEST(NoStickFitTest, BiasOfExactNullsIsTheOneStated) {
    std::vector<Fit> nulls;
    for (const double gamma : {0.5, 0.68, 1.0, 1.5, 2.0, 3.0})
        nulls.push_back({.value = pi / 2 + walker::coulomb_theta(gamma / 0.113),
                         .error = 1e-4,
                         .gamma = gamma * paper_g});
    const Fit fit = fit_no_stick(nulls, 0.113);
    EXPECT_LT(fit.value, 0.113 * 0.87);
    EXPECT_GT(fit.value, 0.113 * 0.76);
    EXPECT_NE(fit.note.find(std::to_string(fit.value).substr(0, 5)), std::string::npos) << fit.note;
    EXPECT_TRUE(std::isnan(fit_no_stick({}, 0.113).value));
}

TEST(NoStickFitTest, RecoversItsOwnLaw) {
    std::vector<Fit> nulls;
    for (const double gamma : {0.5, 1.0, 3.0})
        nulls.push_back({.value = pi / 2 + walker::no_stick_theta(gamma * paper_g, 0.113),
                         .error = 1e-4,
                         .gamma = gamma * paper_g});
    EXPECT_NEAR(fit_no_stick(nulls, NAN).value, 0.113, 1e-9);
}

}  // namespace
}  // namespace shaker::law

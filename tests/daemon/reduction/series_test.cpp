#include "daemon/reduction/series.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "drivers/walker/no_stick.hpp"

namespace shaker::reduction {
namespace {

constexpr double pi = std::numbers::pi;

DrivenPoint point(double phi, double v, double sigma = 1e-5, double gamma = paper_g) {
    return {{.gamma = gamma, .phi = phi}, {gamma, 1e-4 * gamma}, {phi, 1e-4}, {v, sigma}};
}

TEST(MirrorPairTest, RemovesEffectOfTilt) {
    const std::vector points{point(0.3, 0.017), point(0.3 + pi, -0.013)};
    const auto pair = mirror_pair(points);
    ASSERT_TRUE(pair);
    EXPECT_NEAR(pair->drift.value, -0.015, 1e-12);
    EXPECT_NEAR(pair->common.value, 0.002, 1e-12);
    EXPECT_NEAR(pair->drift.sigma, 1e-5 / std::sqrt(2.0), 1e-12);
}

TEST(MirrorPairTest, RequiresTheSameDrive) {
    EXPECT_FALSE(mirror_pair({}));
    EXPECT_FALSE(mirror_pair(std::vector{point(0.3, 0.01), point(0.3 + pi, -0.01, 1e-5, 12)}));
    EXPECT_FALSE(mirror_pair(std::vector{point(0.3, 0.01), point(0.5 + pi, -0.01)}));
    EXPECT_TRUE(mirror_pair(std::vector{point(3 * pi - 0.1, 0.01), point(-0.1, -0.01)})) << "phases wrap";
}

// The law of the paper about its null, bent by a second harmonic of 5 % of it.
double law(double phi, double phi0, double bent) {
    return -0.017 * (std::sin(phi - phi0) + bent * (std::cos(2 * (phi - phi0)) - 1));
}

TEST(NullPhaseTest, LiesBetweenThePoints) {
    const double mu = 0.113, phi0 = pi / 2 + walker::coulomb_theta(1 / mu);
    for (const double bent : {0.0, 0.05, -0.05}) {
        const std::vector points{point(phi0 - 0.11, law(-0.11, 0, bent)),
                                 point(phi0 + 0.06, law(0.06, 0, bent))};
        const auto null = null_phase(points);
        ASSERT_TRUE(null);
        EXPECT_NEAR(null->phi0.value, phi0, 2 * null->phi0.sigma);
        EXPECT_LT(null->phi0.sigma, 2e-3);
    }
}

TEST(NullPhaseTest, StatedIntervalCoversTheTruth) {
    const double mu = 0.113, phi0 = pi / 2 + walker::coulomb_theta(1 / mu), sigma = 2e-5;
    std::mt19937 random{7};
    std::normal_distribution<double> noise;
    int within = 0;
    constexpr int trials = 2000;
    for (int i = 0; i < trials; ++i) {
        const double a = -0.05 + 0.01 * noise(random), b = 0.05 + 0.01 * noise(random);
        const std::vector points{point(phi0 + a, law(a, 0, 0) + sigma * noise(random), sigma),
                                 point(phi0 + b, law(b, 0, 0) + sigma * noise(random), sigma)};
        const auto null = null_phase(points);
        ASSERT_TRUE(null);
        if (std::abs(null->phi0.value - phi0) < 2 * null->phi0.sigma) ++within;
    }
    EXPECT_GT(within, 0.94 * trials);
}

TEST(NullPhaseTest, RejectsOneSidedWideOrRisingPairs) {
    EXPECT_FALSE(null_phase(std::vector{point(2, 0.01), point(2.1, 0.005)})) << "both on one side";
    EXPECT_FALSE(null_phase(std::vector{point(2, 0.01), point(2.3, -0.01)})) << "too wide";
    EXPECT_FALSE(null_phase(std::vector{point(2, -0.01), point(2.1, 0.01)})) << "the other null";
    EXPECT_FALSE(null_phase(std::vector{point(2, 0.01), point(2.1, -0.01, 1e-5, 12)})) << "another gamma";
}

}  // namespace
}  // namespace shaker::reduction

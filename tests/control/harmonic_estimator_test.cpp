#include "daemon/control/harmonic_estimator.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "drivers/errors.hpp"

namespace shaker {
namespace {

Harmonics<Acceleration> target() {
    Harmonics<Acceleration> h = harmonics(Drive{20, 14.7, 0.5, 0.6});
    h.at(3) = std::polar(0.1, 1.0);
    return h;
}

/// Feeds `periods` of a signal at `per_period` samples a turn; returns how many periods were told of.
int feed(HarmonicEstimator& e, double per_period, double periods, const std::array<double, 3>& axis,
         double noise) {
    std::mt19937_64 random(3);
    std::normal_distribution<double> normal(0, 1);
    int told = 0;
    for (int i = 0; i < periods * per_period; ++i) {
        const double turns = i / per_period;
        const double a = value_at(target(), two_pi * turns);
        told += e.add(turns, {a * axis[0] + noise * normal(random), a * axis[1] + noise * normal(random),
                              a * axis[2] + 9.8 + noise * normal(random)});
    }
    return told;
}

TEST(HarmonicEstimatorTest, FindsHarmonicsWhateverTheSamplesPerPeriod) {
    for (const double per_period : {200.0, 199.3, 200.7, 61.803}) {
        HarmonicEstimator e(8, {1, 0, 0});
        ASSERT_EQ(feed(e, per_period, 3.5, {1, 0, 0}, 0), 3);
        ASSERT_TRUE(e.estimate().valid) << per_period;
        for (int q = 1; q <= 8; ++q) {
            // 1e-11 of 10 m/s^2: rounding of the normal equations
            EXPECT_LT(std::abs(e.estimate().harmonics.at(q) - target().at(q)), 1e-10)
                << q << " at " << per_period;
        }
    }
}

TEST(HarmonicEstimatorTest, ProjectsOnTheAxisAndKeepsGravityApart) {
    const double c = std::cos(0.5), s = std::sin(0.5);
    HarmonicEstimator e(4, {2 * c, 0, 2 * s});
    feed(e, 200, 2.5, {c, 0, s}, 0);
    EXPECT_NEAR(std::abs(e.estimate().harmonics.at(1)), 7.35, 1e-9);
    EXPECT_NEAR(e.estimate().offset_mps2, 9.8 * s, 1e-9);
}

TEST(HarmonicEstimatorTest, ClaimedErrorIsNoiseOverRootOfHalfTheSamples) {
    HarmonicEstimator e(8, {1, 0, 0});
    feed(e, 200, 5.5, {1, 0, 0}, 1e-3);
    // sd of a component is noise sqrt(2/n); the residuals of 200 samples know the noise to 5 %, 4 of that
    EXPECT_NEAR(e.estimate().sd[0], 1e-3 * std::sqrt(2 / 200.0), 0.2 * 1e-4);
    EXPECT_NEAR(std::sqrt(e.covariance(0, 0)), 1e-4, 0.2e-4);
    EXPECT_LT(std::abs(e.estimate().harmonics.at(1) - target().at(1)), 5 * e.estimate().sd[0] * 1.5);
}

TEST(HarmonicEstimatorTest, IntegerPhaseIsTheSameAsTurns) {
    HarmonicEstimator turns(3, {1, 0, 0}), integer(3, {1, 0, 0});
    const std::uint64_t step = std::uint64_t{1} << 56U;  // 256 samples a turn
    std::uint64_t phase = 0;
    for (int i = 0; i < 600; ++i, phase += step) {
        const double a = value_at(target(), two_pi * i / 256.0);
        turns.add(i / 256.0, {a, 0, 0});
        integer.add(phase, {a, 0, 0});
    }
    ASSERT_TRUE(integer.estimate().valid);
    EXPECT_EQ(integer.estimate().harmonics, turns.estimate().harmonics);
}

TEST(HarmonicEstimatorTest, APeriodWithAGapIsInvalidAndTheNextOneIsNot) {
    for (const bool told : {true, false}) {  // told by the caller, or seen in the phases
        HarmonicEstimator e(3, {1, 0, 0});
        std::vector<bool> valid;
        for (int i = 0; i < 1000; ++i) {
            if (told && i == 450) e.gap();
            if (!told && i > 450 && i < 480) continue;
            if (e.add(i / 200.0, {std::sin(two_pi * i / 200.0), 0, 0})) valid.push_back(e.estimate().valid);
        }
        ASSERT_EQ(valid.size(), 4U);
        EXPECT_EQ(valid, (std::vector<bool>{false, true, false, true})) << told;
    }
}

TEST(HarmonicEstimatorTest, SamplesThatAreNotFiniteMakeThePeriodInvalid) {
    HarmonicEstimator e(3, {1, 0, 0});
    for (int i = 0; i <= 600; ++i) e.add(i / 200.0, {i == 500 ? std::nan("") : 1.0, 0, 0});
    EXPECT_FALSE(e.estimate().valid);
}

TEST(HarmonicEstimatorTest, RefusesWhatItCannotDo) {
    EXPECT_THROW(HarmonicEstimator(0, {1, 0, 0}), InputError);
    EXPECT_THROW(HarmonicEstimator(17, {1, 0, 0}), InputError);
    EXPECT_THROW(HarmonicEstimator(4, {0, 0, 0}), InputError);
}

}  // namespace
}  // namespace shaker

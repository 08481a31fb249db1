#include "daemon/control/harmonic_estimator.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "tests/support/no_alloc.hpp"

namespace shaker::control {
namespace {

constexpr double per_period = 200;  // 4 kS/s at 20 Hz
constexpr double yaw = 0.035;

struct Sensor {
    Harmonics<Acceleration> base = harmonics(Drive{.gamma = 9.8, .rho = 0.5, .phi = 0.6});
    double noise = 0;
    std::mt19937_64 rng{11};
    std::array<double, 3> at(double turns) {
        std::normal_distribution<double> gauss{0, 1};
        const double a = value_at(base, two_pi * turns);
        return {a * std::cos(yaw) + noise * gauss(rng), -a * std::sin(yaw) + noise * gauss(rng),
                9.8 + noise * gauss(rng)};
    }
};

std::vector<PeriodEstimate> estimates(Sensor& s, HarmonicEstimator& e, int samples, double step) {
    std::vector<PeriodEstimate> out;
    for (int i = 0; i < samples; ++i)
        if (const auto p = e.add(i * step, s.at(i * step))) out.push_back(*p);
    return out;
}

TEST(HarmonicEstimatorTest, IsExactWithoutNoiseForAnySamplesPerPeriod) {
    for (const double n : {200.0, 199.99, 200.37, 61.8}) {
        Sensor s;
        HarmonicEstimator e{{}};
        const auto found = estimates(s, e, 2000, 1 / n);
        ASSERT_GE(found.size(), 9U);
        for (const PeriodEstimate& p : found) {
            EXPECT_LT(std::abs(p.along.at(1) - s.base.at(1)), 1e-10) << n << " samples a period";
            EXPECT_LT(std::abs(p.along.at(2) - s.base.at(2)), 1e-10);
            EXPECT_LT(std::abs(p.along.at(3)), 1e-10);
            EXPECT_NEAR(p.axis[1], -std::sin(yaw), 1e-10);
        }
    }
}

// Gravity goes in the middle of one period and comes back in another: the step is strong in harmonics 1 and
// 2, but it is not the direction of the shaker. Before, the sign of all later windows could turn.
TEST(HarmonicEstimatorTest, LostGravityDoesNotTurnTheDirection) {
    for (const double phase : {0.1, 0.3, 0.5, 0.7, 0.9}) {
        Sensor s;
        s.noise = 1e-3;
        HarmonicEstimator e{{}};
        std::vector<PeriodEstimate> found;
        for (int i = 0; i < 2000; ++i) {
            const double turns = i / per_period;
            auto a = s.at(turns);
            if (turns > 3 + phase && turns < 5 + phase) a = {0.01, 0.01, 0};  // the lead is off
            if (const auto p = e.add(turns, a)) found.push_back(*p);
        }
        EXPECT_GT(found.front().axis[0], 0.99);
        EXPECT_GT(found.back().axis[0], 0.99) << "lost at phase " << phase;
        EXPECT_GT(e.direction()[0], 0.99);
    }
}

// A sensor that was mounted otherwise is followed.
TEST(HarmonicEstimatorTest, AnotherDirectionCountsAfterThreeWindows) {
    Sensor s;
    HarmonicEstimator e{{}};
    for (int i = 0; i < 2000; ++i) {
        const double turns = i / per_period;
        auto a = s.at(turns);
        if (turns > 4) std::swap(a[0], a[1]);
        static_cast<void>(e.add(turns, a));
        EXPECT_TRUE(turns < 1.01 || turns > 6.99 || std::abs(e.direction()[0]) > 0.99) << turns;
    }
    EXPECT_GT(std::abs(e.direction()[1]), 0.99);
}

TEST(HarmonicEstimatorTest, StatedDeviationMatchesScatter) {
    Sensor s;
    s.noise = 0.011;
    HarmonicEstimator e{{.axis = {std::cos(yaw), -std::sin(yaw), 0}}};
    const auto found = estimates(s, e, 200 * 2001, 1 / per_period);
    double squares = 0, stated = 0;
    for (const PeriodEstimate& p : found) {
        squares += std::norm(p.along.at(2) - s.base.at(2)) / 2;  // two components
        stated += p.sd * p.sd;
    }
    EXPECT_NEAR(std::sqrt(squares / stated), 1,
                0.05);  // 2000 periods determine a standard deviation to 1.6 %
    const double white = s.noise * std::sqrt(2 / per_period);  // the Cramer-Rao bound for white noise
    EXPECT_NEAR(std::sqrt(squares / static_cast<double>(found.size())), white, 0.05 * white);
}

TEST(HarmonicEstimatorTest, GivesNoEstimateForPeriodWithGap) {
    Sensor s;
    HarmonicEstimator e{{}};
    std::vector<std::int64_t> periods;
    for (int i = 0; i < 1200; ++i) {
        if (i >= 450 && i < 480) continue;  // 15 % of period 2
        if (const auto p = e.add(i / per_period, s.at(i / per_period))) periods.push_back(p->period);
    }
    EXPECT_EQ(periods, (std::vector<std::int64_t>{0, 1, 3, 4}));
}

TEST(HarmonicEstimatorTest, CovarianceMatchesManyPeriods) {
    Sensor s;
    s.noise = 0.02;
    // The beginning of every period is missing: harmonics are no longer orthogonal.
    HarmonicEstimator e{{.harmonics = 2, .axis = {std::cos(yaw), -std::sin(yaw), 0}}};
    s.base = {};
    s.base.at(1) = 3;
    double product = 0, square = 0, stated_product = 0, stated_square = 0;
    int n = 0;
    for (int i = 0; i < 40 * 20000; ++i) {
        if (i % 40 < 3) continue;
        const auto p = e.add(i / 40.0, s.at(i / 40.0));
        if (!p) continue;
        const double first = p->along.at(1).imag(), second = p->along.at(2).imag();
        product += first * second;
        square += first * first;
        stated_product += p->covariance(1, 3);
        stated_square += p->covariance(1, 1);
        ++n;
    }
    ASSERT_GT(n, 15000);
    EXPECT_NEAR(square / stated_square, 1, 0.05);
    EXPECT_NEAR(product / stated_product, 1, 0.2);
    EXPECT_GT(std::abs(product), 0.05 * square);
}

TEST(HarmonicEstimatorTest, SeparatesMainsLineBetweenHarmonics) {
    EXPECT_EQ(periods_to_tell(50.0 / 20, 8), 2);
    EXPECT_EQ(periods_to_tell(50.0 / 25, 8), 0);  // it is harmonic 2
    EXPECT_EQ(periods_to_tell(0, 8), 1);
    EXPECT_EQ(periods_to_tell(60.0 / 25, 8), 3);
    EXPECT_EQ(periods_to_tell(200.0 / 20, 8), 1);  // beyond all that is controlled
    for (const double ratio : {2.5, 2.4, 3.3}) {
        Sensor s;
        EstimatorSettings settings;
        settings.periods = periods_to_tell(ratio, 8);
        settings.line = ratio;
        settings.samples = 1200;
        HarmonicEstimator e{settings};
        int found = 0;
        for (int i = 0; i < 6000; ++i) {
            auto a = s.at(i / per_period);
            for (double& x : a) x += 0.05 * std::sin(two_pi * ratio * i / per_period + 1);
            const auto p = e.add(i / per_period, a);
            if (!p) continue;
            ++found;
            EXPECT_LT(std::abs(p->along.at(2) - s.base.at(2)), 1e-9) << ratio;
            EXPECT_LT(std::abs(p->along.at(3)), 1e-9) << ratio;
        }
        EXPECT_GT(found, 8);
    }
}

TEST(HarmonicEstimatorTest, SeparatesMotionAcrossTheAxis) {
    HarmonicEstimator e{{.axis = {1, 0, 0}}};
    std::optional<PeriodEstimate> p;
    for (int i = 0; i <= 200; ++i) {
        const double t = two_pi * i / per_period;
        if (const auto done =
                e.add(i / per_period, {5 * std::sin(t), 0.2 * std::cos(t), 9.8 + 0.1 * std::sin(t)}))
            p = done;
    }
    ASSERT_TRUE(p);
    const double rocking = std::hypot(p->across[0].at(1).imag(), p->across[1].at(1).imag());
    const double oblique = std::hypot(p->across[0].at(1).real(), p->across[1].at(1).real());
    EXPECT_NEAR(rocking, 0.2, 1e-9);  // in quadrature
    EXPECT_NEAR(oblique, 0.1, 1e-9);  // in phase
    EXPECT_NEAR(p->mean[2], 9.8, 1e-9);
}

TEST(HarmonicEstimatorTest, AddDoesNotAllocate) {
    Sensor s;
    HarmonicEstimator e{{}};
    estimates(s, e, 500, 1 / per_period);
    std::vector<std::array<double, 3>> a(500);
    for (std::size_t i = 0; i < a.size(); ++i) a[i] = s.at(static_cast<double>(i) / per_period);
    int found = 0;
    {
        const test::NoAlloc guard;
        for (int i = 0; i < 500; ++i)
            found += e.add(3 + i / per_period, a[static_cast<std::size_t>(i)]) ? 1 : 0;
    }
    EXPECT_EQ(found, 2);
}

}  // namespace
}  // namespace shaker::control

#include "daemon/control/harmonic_estimator.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "tests/support/no_alloc.hpp"

namespace shaker {
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

TEST(HarmonicEstimatorTest, IsExactWithoutNoiseAtAnyNumberOfSamplesAPeriod) {
    for (const double n : {200.0, 199.99, 200.37, 61.8}) {
        Sensor s;
        HarmonicEstimator e{8, 300, {}};
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

TEST(HarmonicEstimatorTest, TheStatedDeviationIsTheRealOne) {
    Sensor s;
    s.noise = 0.011;
    HarmonicEstimator e{8, 300, {std::cos(yaw), -std::sin(yaw), 0}};
    const auto found = estimates(s, e, 200 * 2001, 1 / per_period);
    double squares = 0, stated = 0;
    for (const PeriodEstimate& p : found) {
        squares += std::norm(p.along.at(2) - s.base.at(2)) / 2;  // two components
        stated += p.sd * p.sd;
    }
    EXPECT_NEAR(std::sqrt(squares / stated), 1, 0.05);         // 2000 periods tell a deviation to 1.6 %
    const double white = s.noise * std::sqrt(2 / per_period);  // the Cramer-Rao bound for white noise
    EXPECT_NEAR(std::sqrt(squares / static_cast<double>(found.size())), white, 0.05 * white);
}

TEST(HarmonicEstimatorTest, APeriodWithAGapGivesNoEstimate) {
    Sensor s;
    HarmonicEstimator e{8, 300, {}};
    std::vector<std::int64_t> periods;
    for (int i = 0; i < 1200; ++i) {
        if (i >= 450 && i < 480) continue;  // 15 % of period 2
        if (const auto p = e.add(i / per_period, s.at(i / per_period))) periods.push_back(p->period);
    }
    EXPECT_EQ(periods, (std::vector<std::int64_t>{0, 1, 3, 4}));
}

TEST(HarmonicEstimatorTest, AddDoesNotAllocate) {
    Sensor s;
    HarmonicEstimator e{8, 300, {}};
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
}  // namespace shaker

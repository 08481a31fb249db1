#include "calibration/harmonics/harmonic_fit.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "drivers/drive.hpp"
#include "drivers/errors.hpp"

namespace shaker::calibration {
namespace {

struct Signal {
    std::vector<double> t, y;
    [[nodiscard]] HarmonicSamples samples() const { return {t, y, {}}; }
};

constexpr double f = 20.0;
const std::complex<double> a1{1.0, 0.3}, a2{-0.4, 0.2};

double clean(double t, double frequency = f) {
    const double p = two_pi * frequency * t;
    return (a1 * std::polar(1.0, p)).imag() + (a2 * std::polar(1.0, 2 * p)).imag();
}

/// Irregular times with a gap, constant 5, slope 2 per s.
Signal rough(double noise, unsigned seed) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> step(0.2e-3, 1.8e-3);
    Signal s;
    for (double t = 3; t < 4; t += step(random)) {
        if (t > 3.4 && t < 3.52) continue;
        s.t.push_back(t);
        s.y.push_back(clean(t) + 5 + 2 * (t - 3) + noise * normal(random));
    }
    return s;
}

std::complex<double> at_zero(const HarmonicFit& fit, int q) {
    return fit.at(q) * std::polar(1.0, -two_pi * q * fit.frequency_hz * fit.origin_s);
}

TEST(HarmonicFitTest, RecoversHarmonicsConstantAndSlopeThroughGaps) {
    const Signal s = rough(0, 1);
    const HarmonicSamples in = s.samples();
    const auto fit = fit_harmonics({&in, 1}, f, 4, Slope::free);
    // 1e-11: a thousand sums of numbers of size 5 in double
    EXPECT_LT(std::abs(at_zero(fit, 1) - a1), 1e-11);
    EXPECT_LT(std::abs(at_zero(fit, 2) - a2), 1e-11);
    EXPECT_LT(std::abs(fit.at(3)) + std::abs(fit.at(4)), 1e-11);
    EXPECT_NEAR(fit.slope.value, 2, 1e-10);
    EXPECT_NEAR(fit.constants[0], 5 + 2 * (fit.origin_s - 3), 1e-11);
    EXPECT_LT(fit.rms, 1e-10);
}

TEST(HarmonicFitTest, StatedErrorsMatchRepeatedRuns) {
    constexpr int runs = 400;
    double amplitude = 0, phase = 0, slope = 0;
    for (unsigned seed = 0; seed < runs; ++seed) {
        const Signal s = rough(0.1, seed);
        const HarmonicSamples in = s.samples();
        const auto fit = fit_harmonics({&in, 1}, f, 4, Slope::free);
        amplitude += std::pow((std::abs(fit.at(2)) - std::abs(a2)) / fit.amplitude_sd(2), 2);
        phase += std::pow(std::arg(at_zero(fit, 2) / a2) / fit.phase_sd(2), 2);
        slope += std::pow((fit.slope.value - 2) / fit.slope.sigma, 2);
    }
    // The mean of 400 squared normal numbers is 1 +- 0.07: 4 of that.
    EXPECT_NEAR(amplitude / runs, 1, 0.28);
    EXPECT_NEAR(phase / runs, 1, 0.28);
    EXPECT_NEAR(slope / runs, 1, 0.28);
}

TEST(HarmonicFitTest, StreamsShareHarmonicsAndKeepTheirOwnConstants) {
    Signal a = rough(0, 1), b = rough(0, 2);
    for (double& y : b.y) y += 100;
    const std::array<HarmonicSamples, 2> both{a.samples(), b.samples()};
    const auto fit = fit_harmonics(both, f, 2, Slope::free);
    EXPECT_NEAR(fit.constants[1] - fit.constants[0], 100, 1e-9);
    EXPECT_LT(std::abs(at_zero(fit, 1) - a1), 1e-9);
}

TEST(HarmonicFitTest, WeightsFollowTheStandardDeviations) {
    Signal good = rough(0, 1), bad = rough(3, 2);
    const std::vector<double> small(good.t.size(), 1e-3), large(bad.t.size(), 3);
    const std::array<HarmonicSamples, 2> both{HarmonicSamples{good.t, good.y, small},
                                              HarmonicSamples{bad.t, bad.y, large}};
    // The bad stream weighs 1e-7 of the good one: its 3/sqrt(800) shifts the result by 1e-8.
    EXPECT_LT(std::abs(at_zero(fit_harmonics(both, f, 2, Slope::free), 1) - a1), 1e-6);
}

class FrequencyTest : public ::testing::TestWithParam<std::pair<double, double>> {};

TEST_P(FrequencyTest, ConvergesFromOnePercentAway) {
    const auto [off, seconds] = GetParam();
    const double truth = f * (1 + off);
    Signal s;
    for (int i = 0; i < seconds * 1000; ++i) {
        const double t = 1e-3 * i;
        s.t.push_back(t);
        s.y.push_back(clean(t, truth));
    }
    const HarmonicSamples in = s.samples();
    const Estimate found = refine_frequency({&in, 1}, f, 2);
    EXPECT_NEAR(found.value / truth, 1, 1e-10);
}

INSTANTIATE_TEST_SUITE_P(Offsets, FrequencyTest,
                         ::testing::Values(std::pair{1e-4, 0.3}, std::pair{-2e-4, 2.0}, std::pair{0.01, 10.0},
                                           std::pair{-0.01, 60.0}, std::pair{1e-4, 120.0}));

TEST(HarmonicFitTest, FrequencyErrorMatchesRepeatedRuns) {
    constexpr int runs = 300;
    double squares = 0;
    for (unsigned seed = 0; seed < runs; ++seed) {
        Signal s = rough(0.2, seed);
        for (std::size_t i = 0; i < s.t.size(); ++i) s.y[i] -= 2 * (s.t[i] - 3);
        const HarmonicSamples in = s.samples();
        const Estimate found = refine_frequency({&in, 1}, f * 1.0001, 2);
        squares += std::pow((found.value - f) / found.sigma, 2);
    }
    EXPECT_NEAR(squares / runs, 1, 0.33);  // 4 standard deviations of the mean of 300 squares
}

TEST(HarmonicFitTest, TooFewSamplesAreRefusedWithTheCounts) {
    const Signal s{{0, 0.01, 0.02, 0.03}, {0, 1, 0, 1}};
    const HarmonicSamples in = s.samples();
    try {
        fit_harmonics({&in, 1}, f, 2, Slope::none);
        FAIL() << "4 samples cannot give 5 unknowns";
    } catch (const InputError& e) {
        EXPECT_NE(std::string(e.what()).find("4 samples for 5 unknowns"), std::string::npos) << e.what();
    }
}

TEST(HarmonicFitTest, TimesThatAliasHarmonicsAreRefused) {
    Signal s;
    for (int i = 0; i < 100; ++i) {  // two samples a period: harmonic 2 looks like a constant
        s.t.push_back(i * 0.025);
        s.y.push_back(i % 2);
    }
    const HarmonicSamples in = s.samples();
    EXPECT_THROW(fit_harmonics({&in, 1}, f, 2, Slope::none), InputError);
}

TEST(HarmonicFitTest, OrderStaysBelowAThirdOfTheSamplesPerPeriod) {
    EXPECT_EQ(order_for(50, 12), 12);
    EXPECT_EQ(order_for(24, 12), 8);
    EXPECT_EQ(order_for(5, 12), 2);
    EXPECT_EQ(order_for(3, 12), 1);
}

}  // namespace
}  // namespace shaker::calibration

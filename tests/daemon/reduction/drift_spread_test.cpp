#include "daemon/reduction/drift_spread.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <iomanip>
#include <iostream>

#include "daemon/reduction/drift.hpp"
#include "tests/support/run/synthetic_run.hpp"

namespace shaker::reduction {
namespace {

struct Scatter {
    const char* name;
    double jitter;  // relative, of D
    double memory;  // AR(1) from one millisecond to the next
};

struct Coverage {
    int periods;
    int runs;
    double frame_rate_hz;
};

/// Share of runs in which the true v_D lies within 2 sigma.
double coverage(const Coverage& c, const Scatter& s) {
    int within = 0;
    double squares = 0, claimed = 0;
    for (int i = 0; i < c.runs; ++i) {
        SyntheticRun run;
        run.drive.gamma = paper_g;
        run.periods = c.periods;
        run.frame_rate_hz = c.frame_rate_hz;
        run.drift_jitter = s.jitter;
        run.noise_memory = std::pow(s.memory, 1000 / c.frame_rate_hz);
        run.accel_rate_hz = 10;  // not used here
        run.seed = 5000 + static_cast<std::uint64_t>(i);
        const Measurement m = make_measurement(run);
        std::vector<std::string> notes;
        const calibration::Estimate v = measure_drift(m.walkers, run.drive.frequency, notes).v_D;
        const double error = v.value - drift_velocity(run);
        within += std::abs(error) <= 2 * v.sigma;
        squares += error * error;
        claimed += v.sigma;
    }
    const double share = static_cast<double>(within) / c.runs;
    std::cout << std::setw(4) << c.periods << " periods, " << std::setw(12) << s.name << ": covered "
              << std::fixed << std::setprecision(3) << share << ", rmse " << 1e6 * std::sqrt(squares / c.runs)
              << " um/s, mean sigma " << 1e6 * claimed / c.runs << " um/s\n";
    return share;
}

class CoverageTest : public ::testing::TestWithParam<std::tuple<Coverage, Scatter>> {};

// Required coverage: at least 0.92. 400 runs determine a coverage of 0.95 to 0.011. There is no upper limit
// for white noise: small jitter cannot be excluded then, and sigma must include it.
TEST_P(CoverageTest, TwoSigmaCoverTheTruthForAnyNoise) {
    const auto& [c, s] = GetParam();
    const double share = coverage(c, s);
    EXPECT_GE(share, 0.92);
    if (s.jitter >= 0.02) {
        EXPECT_LE(share, 0.99);
    }
}

constexpr Scatter scatters[] = {{"white", 0, 0},
                                {"0.03 % jitter", 3e-4, 0},
                                {"0.1 % jitter", 1e-3, 0},
                                {"2 % jitter", 0.02, 0},
                                {"AR(1) 0.9", 0, 0.9}};

INSTANTIATE_TEST_SUITE_P(Short, CoverageTest,
                         ::testing::Combine(::testing::Values(Coverage{6, 400, 1000},
                                                              Coverage{12, 1000, 1000},
                                                              Coverage{40, 400, 1000}),
                                            ::testing::ValuesIn(scatters)));
// 200 periods with fewer frames, which saves time without changing the result.
INSTANTIATE_TEST_SUITE_P(Long, CoverageTest,
                         ::testing::Combine(::testing::Values(Coverage{200, 400, 300}),
                                            ::testing::ValuesIn(scatters)));

TEST(DriftSpreadTest, SigmaWithoutScatterEqualsGivenError) {
    std::vector<PeriodMean> means(40);
    for (int k = 0; k < 40; ++k) means[static_cast<std::size_t>(k)] = {k, 1e-3 * k, 50};
    const DriftSpread s = drift_spread(means, {1e-9, 1e-9});
    // 12 sigma^2 / N^3 for the line; at most 3 times that, see the header
    EXPECT_GT(s.sigma_m, 1e-9 * std::sqrt(12 / std::pow(40, 3)));
    EXPECT_LT(s.sigma_m, 3 * 1e-9 * std::sqrt(12 / std::pow(40, 3)));
}

TEST(DriftSpreadTest, IgnoresAnAddedStraightLine) {
    std::vector<PeriodMean> flat, sloped;
    for (int k = 0; k < 12; ++k) {
        const double y = 1e-6 * std::sin(17.0 * k);
        flat.push_back({k, y, 50});
        sloped.push_back({k, y + 7e-4 * k, 50});
    }
    EXPECT_NEAR(drift_spread(flat, {1e-7, 2e-7}).sigma_m, drift_spread(sloped, {1e-7, 2e-7}).sigma_m, 1e-13);
}

TEST(DriftSpreadTest, MissingPeriodsDoNotRaiseScatter) {
    std::vector<PeriodMean> means;
    for (int k = 0; k < 40; ++k) {
        if (k == 7 || k == 8 || k == 20) continue;
        means.push_back({k, 7e-4 * k + 1e-7 * std::sin(29.0 * k), 50});
    }
    EXPECT_LT(drift_spread(means, {1e-7, 1e-7}).jitter_m, 1e-7);
}

TEST(DriftSpreadTest, TwoPeriodsGiveInfiniteSigma) {
    const std::vector<PeriodMean> means{{0, 0, 50}, {1, 1e-3, 50}};
    EXPECT_TRUE(std::isinf(drift_spread(means, {1e-7, 1e-7}).sigma_m));
}

TEST(DriftTest, ReportsSettlingWalkerAndCoversFinalDrift) {
    SyntheticRun run;
    run.periods = 20;
    run.settling = -0.3;
    run.contraction = 0.85;
    std::vector<std::string> notes;
    const calibration::Estimate v = measure_drift(make_measurement(run).walkers, 20, notes).v_D;
    ASSERT_EQ(notes.size(), 1U);
    EXPECT_NE(notes[0].find("settling"), std::string::npos) << notes[0];
    const double last = drift_velocity(run) * (1 - 0.3 * std::pow(0.85, 19));
    EXPECT_LT(std::abs(v.value - last), 2 * v.sigma);
}

TEST(DriftTest, RarelyReportsSettledWalkerAsSettling) {
    int said = 0;
    for (std::uint64_t seed = 0; seed < 200; ++seed) {
        SyntheticRun run;
        run.periods = 12;
        run.drift_jitter = 0.02;
        run.accel_rate_hz = 10;
        run.seed = seed;
        std::vector<std::string> notes;
        measure_drift(make_measurement(run).walkers, 20, notes);
        said += notes.empty() ? 0 : 1;
    }
    EXPECT_LE(said, 8);  // 1 % expected
}

TEST(DriftTest, ViewsOfDifferentScaleWidenErrorWithNote) {
    SyntheticRun run;
    run.views = 2;
    Measurement m = make_measurement(run);
    for (double& x : m.walkers[1].x_m) x *= 1.02;
    std::vector<std::string> notes;
    const calibration::Estimate v = measure_drift(m.walkers, 20, notes).v_D;
    ASSERT_EQ(notes.size(), 1U);
    EXPECT_NE(notes[0].find("'top' and 'side'"), std::string::npos) << notes[0];
    EXPECT_NEAR(v.sigma, 0.01 * drift_velocity(run), 0.001 * drift_velocity(run));
}

class GridTest : public ::testing::TestWithParam<double> {};

// Frame rates that are commensurate, nearly commensurate, and low: harmonics beyond the fit must not become
// drift.
TEST_P(GridTest, NoiseFreeDriftHasNoBias) {
    for (const double start : {0.00015, 0.0131, 0.0377}) {
        SyntheticRun run;
        run.drive.gamma = paper_g;
        run.frame_rate_hz = GetParam();
        run.position_noise_m = 0;
        run.start_s = start;
        run.accel_rate_hz = 10;
        std::vector<std::string> notes;
        const calibration::Estimate v = measure_drift(make_measurement(run).walkers, 20, notes).v_D;
        EXPECT_LT(std::abs(v.value - drift_velocity(run)), 0.1e-6)
            << "start " << start;  // goal: bias below 0.1 um/s
    }
}

INSTANTIATE_TEST_SUITE_P(FrameRates, GridTest,
                         ::testing::Values(1000, 997, 480, 500, 1001.3, 333.3, 250, 205, 240.1));

}  // namespace
}  // namespace shaker::reduction

#include "daemon/reduction/spread/drift_spread.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <iostream>
#include <random>

#include "daemon/reduction/drift.hpp"
#include "tests/support/nightly.hpp"
#include "tests/support/run/synthetic_run.hpp"

namespace shaker::reduction {
namespace {

struct Row {
    const char* name;
    int periods;
    double jitter = 0;                   // relative, of D
    double memory = 0;                   // AR(1) coefficient of the jitter, per period
    double noise_memory = 0;             // AR(1) coefficient of the positions, per millisecond
    double least = 0.917, most = 0.983;  // share within 2 sigma
    double least_z = 0.85, most_z = 1.15;
};

struct Coverage {
    double share = 0, z_rms = 0, mean_sigma = 0, rmse = 0;
};

Coverage coverage(const Row& row, int runs) {
    Coverage out;
    double z2 = 0, squares = 0;
    for (int i = 0; i < runs; ++i) {
        SyntheticRun run;
        run.drive.gamma = paper_g;
        run.periods = row.periods;
        run.frame_rate_hz = row.periods > 100 ? 300 : 1000;
        run.drift_jitter = row.jitter;
        run.drift_memory = row.memory;
        run.noise_memory = row.noise_memory;
        run.accel_rate_hz = 10;  // not used here
        run.seed = 5000 + static_cast<std::uint64_t>(i);
        std::vector<std::string> notes;
        const calibration::Estimate v =
            measure_drift(make_measurement(run).walkers, run.drive.frequency, 0, notes).v_D;
        const double error = v.value - drift_velocity(run);
        out.share += std::abs(error) <= 2 * v.sigma ? 1.0 / runs : 0.0;
        z2 += error * error / (v.sigma * v.sigma) / runs;
        squares += error * error / runs;
        out.mean_sigma += v.sigma / runs;
    }
    out.z_rms = std::sqrt(z2);
    out.rmse = std::sqrt(squares);
    std::cout << std::setw(5) << row.periods << " periods, " << std::setw(20) << row.name << ": covered "
              << std::fixed << std::setprecision(3) << out.share << ", z rms " << out.z_rms << ", rmse "
              << 1e6 * out.rmse << " um/s, mean sigma " << 1e6 * out.mean_sigma << " um/s\n";
    return out;
}

class CoverageTest : public ::testing::TestWithParam<Row> {};

// 95 % within three binomial errors of 400 runs. tests/bench/truth.cpp has more rows.
TEST_P(CoverageTest, TwoSigmaCoverTheTruthForAnyNoise) {
    const Coverage c = coverage(GetParam(), 400);
    EXPECT_GE(c.share, GetParam().least);
    EXPECT_LE(c.share, GetParam().most);
    EXPECT_GE(c.z_rms, GetParam().least_z);
    EXPECT_LE(c.z_rms, GetParam().most_z);
}

// With 6 periods jitter cannot be excluded, so that white noise alone is covered more often. With memory 0.8,
// 40 periods are worth 4.4: at least 90 %.
INSTANTIATE_TEST_SUITE_P(Rows, CoverageTest,
                         ::testing::Values(Row{"white", 6, 0, 0, 0, 0.917, 1, 0},
                                           Row{"2 % jitter", 6, 0.02, 0, 0, 0.917, 1, 0}, Row{"white", 12},
                                           Row{"2 % jitter", 12, 0.02, 0, 0, 0.917, 0.988, 0.75},
                                           Row{"white", 40}, Row{"0.5 % jitter", 40, 5e-3},
                                           Row{"2 % jitter", 40, 0.02}, Row{"2 %, memory 0.5", 40, 0.02, 0.5},
                                           Row{"2 %, memory 0.8", 40, 0.02, 0.8, 0, 0.9, 1, 0.6, 1.4},
                                           Row{"positions' memory", 40, 0, 0, 0.9, 0.917, 1, 0.5},
                                           Row{"0.1 % jitter", 200, 1e-3},
                                           Row{"2 %, memory 0.9", 200, 0.02, 0.9}));

// Jitter near the error of a mean, which a short record cannot show: the limit in drift_spread.hpp. The
// bounds are what the prior gives, less three binomial errors.
INSTANTIATE_TEST_SUITE_P(SlightJitter, CoverageTest,
                         ::testing::Values(Row{"0.03 % jitter", 6, 3e-4, 0, 0, 0.91, 1, 0, 1.4},
                                           Row{"0.1 % jitter", 6, 1e-3, 0, 0, 0.82, 1, 0, 2},
                                           Row{"0.03 % jitter", 12, 3e-4, 0, 0, 0.61, 1, 0, 2.8},
                                           Row{"0.1 % jitter", 12, 1e-3, 0, 0, 0.88, 1, 0, 2.3},
                                           Row{"0.03 % jitter", 40, 3e-4, 0, 0, 0.84, 1, 0, 3},
                                           Row{"0.1 % jitter", 40, 1e-3, 0, 0, 0.917, 1, 0.7},
                                           Row{"0.03 % jitter", 200, 3e-4}));

TEST(CoverageTest, ErrorFallsWithTheLengthOfTheRecord) {
    const double at_20 = coverage({"white", 20}, 40).mean_sigma,
                 at_40 = coverage({"white", 40}, 40).mean_sigma;
    EXPECT_LT(at_40, at_20 / 2);  // as N^-1.5 for white noise: 0.35
}

TEST(CoverageTest, ErrorIsNearTheBoundInWhiteNoise) {
    const Coverage c = coverage({"white", 40}, 400);
    const double bound = 2e-6 * std::sqrt(12.0 / (50 * 40.0 * (40 * 40 - 1))) * 20;  // Cramer-Rao, m/s
    EXPECT_LT(c.rmse, 1.1 * bound);
    EXPECT_LT(c.mean_sigma, 1.2 * bound);
}

TEST(DriftSpreadTest, WhiteNoiseGivesErrorOfLeastSquares) {
    std::mt19937_64 random{1};
    std::normal_distribution<double> normal{0, 1e-7};
    std::vector<double> sigmas, independent;
    for (int run = 0; run < 9; ++run) {
        std::vector<PeriodMean> means;
        for (int k = 0; k < 100; ++k) means.push_back({k, 1e-3 * k + normal(random), 50});
        const DriftSpread s = drift_spread(means, {1e-7, 1e-7, 100, 1e-6});
        sigmas.push_back(s.sigma_m);
        independent.push_back(s.independent);
    }
    std::ranges::sort(sigmas);
    std::ranges::sort(independent);
    const double least_squares = 1e-7 * std::sqrt(12 / (100 * (100 * 100 - 1.0)));
    EXPECT_NEAR(sigmas[4], least_squares, 0.1 * least_squares);
    EXPECT_NEAR(independent[4], 100, 1);
}

TEST(DriftSpreadTest, FindsJitterAndMemory) {
    std::mt19937_64 random{1};
    std::normal_distribution<double> normal;
    std::vector<PeriodMean> means;
    double x = 0, u = normal(random);
    for (int k = 0; k < 2000; ++k) {
        means.push_back({k, 1e-6 * (x + u / 2), 50});
        x += u;
        u = 0.8 * u + 0.6 * normal(random);
    }
    const DriftSpread s = drift_spread(means, {1e-8, 1e-8, 2000, 1e-7});
    EXPECT_NEAR(s.jitter_m, 1e-6, 0.1e-6);
    EXPECT_NEAR(s.memory, 0.8, 0.05);
    EXPECT_NEAR(s.independent, 2000.0 / 9, 40);
    // the mean of N values with memory r: (1 + r)/(1 - r)/N; a line's weights: 6/5
    EXPECT_NEAR(s.sigma_m, 1e-6 * std::sqrt(1.2 * 9 / 2000), 0.15e-6 * std::sqrt(1.2 * 9 / 2000));
}

TEST(DriftSpreadTest, IsTheSameBackwardsAndUpsideDown) {
    std::vector<PeriodMean> means, backwards, upside_down;
    for (int k = 0; k < 30; ++k) means.push_back({k, 1e-6 * std::sin(17.0 * k * k), 50});
    for (int k = 0; k < 30; ++k) {
        backwards.push_back({k, means[static_cast<std::size_t>(29 - k)].y_m, 50});
        upside_down.push_back({k, -means[static_cast<std::size_t>(k)].y_m, 50});
    }
    const ScatterPrior prior{1e-7, 1e-7, 30, 1e-7};
    const double sigma = drift_spread(means, prior).sigma_m;
    EXPECT_NEAR(drift_spread(backwards, prior).sigma_m, sigma, 1e-6 * sigma);
    EXPECT_NEAR(drift_spread(upside_down, prior).sigma_m, sigma, 1e-6 * sigma);
}

TEST(DriftSpreadTest, SlowDriftOfDIsReportedAsTooShort) {
    std::vector<PeriodMean> means;
    for (int k = 0; k < 20; ++k) means.push_back({k, 1e-6 * std::sin(0.25 * k), 50});
    EXPECT_LT(drift_spread(means, {1e-8, 1e-8, 20, 1e-7}).independent, 4);
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
    EXPECT_LT(drift_spread(means, {1e-7, 1e-7, 37}).jitter_m, 1e-7);
}

TEST(DriftSpreadTest, TwoPeriodsGiveInfiniteSigma) {
    const std::vector<PeriodMean> means{{0, 0, 50}, {1, 1e-3, 50}};
    EXPECT_TRUE(std::isinf(drift_spread(means, {1e-7, 1e-7}).sigma_m));
}

TEST(DriftTest, ReportsSettlingWalkerAndItsSettledDrift) {
    SyntheticRun run;
    run.periods = 20;
    run.settling = -0.3;
    run.contraction = 0.85;
    std::vector<std::string> notes;
    const Drift drift = measure_drift(make_measurement(run).walkers, 20, 0, notes);
    ASSERT_EQ(notes.size(), 1U) << notes.back();
    EXPECT_NE(notes[0].find("settling"), std::string::npos) << notes[0];
    EXPECT_LT(std::abs(drift.v_D.value - drift_velocity(run)), 2 * drift.v_D.sigma);
    EXPECT_LT(std::abs(drift.settled.value - drift_velocity(run)), 2 * drift.settled.sigma);
    EXPECT_LT(drift.settled.sigma, 0.1 * drift.v_D.sigma);
}

// A walker that was measured before it had settled, by a tail that few records show: it is in the error.
TEST(DriftTest, TailsTooSmallToBeSeenAreInTheError) {
    const int seeds = test::plays(40, 2000);
    for (const double tail : {0.0, 1e-4, 2e-4, 4e-4, 8e-4, 2e-3}) {
        int far = 0, said = 0;
        for (int seed = 0; seed < seeds; ++seed) {
            SyntheticRun run;
            run.settling = tail;
            run.contraction = 0.88;
            run.seed = static_cast<unsigned>(seed);
            std::vector<std::string> notes;
            const Drift drift = measure_drift(make_measurement(run).walkers, 20, 0, notes);
            far += std::abs(drift.v_D.value - drift_velocity(run)) > 3 * drift.v_D.sigma;
            said += !notes.empty();
        }
        std::printf("| %g of D, shrinking to 0.88 a period | %d | %d of %d beyond 3 errors |\n", tail, said,
                    far, seeds);
        EXPECT_LE(far, seeds / (tail == 1e-4 ? 5 : 20))
            << tail;  // 1e-4: 0.07 um, hidden in one record of eight
    }
}

TEST(DriftTest, TrimmedDriveIsNotASettlingWalker) {
    SyntheticRun run;
    run.settling = -1e-3;
    run.contraction = 0.85;
    std::vector<std::string> notes;
    const double change = 1e-3 * drift_velocity(run);
    const Drift drift = measure_drift(make_measurement(run).walkers, 20, 1.5 * change, notes);
    EXPECT_TRUE(notes.empty()) << notes[0];
    EXPECT_TRUE(std::isnan(drift.settled.value));
    EXPECT_LT(drift.v_D.sigma, 0.2e-6);  // as without the change
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
        measure_drift(make_measurement(run).walkers, 20, 0, notes);
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
    const calibration::Estimate v = measure_drift(m.walkers, 20, 0, notes).v_D;
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
        const calibration::Estimate v = measure_drift(make_measurement(run).walkers, 20, 0, notes).v_D;
        EXPECT_LT(std::abs(v.value - drift_velocity(run)), 0.1e-6)
            << "start " << start;  // goal: bias below 0.1 um/s
    }
}

INSTANTIATE_TEST_SUITE_P(FrameRates, GridTest,
                         ::testing::Values(1000, 997, 480, 500, 1001.3, 333.3, 250, 205, 240.1));

}  // namespace
}  // namespace shaker::reduction

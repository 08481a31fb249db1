#include "daemon/reduction/reduction.hpp"

#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <iostream>

#include "drivers/errors.hpp"
#include "tests/support/run/synthetic_run.hpp"
#include "tests/support/shared_data.hpp"

namespace shaker::reduction {
namespace {

void expect_within(const calibration::Estimate& e, double truth, double sigmas, const char* what) {
    EXPECT_LT(std::abs(e.value - truth), sigmas * e.sigma) << what << ": " << e.value << " +- " << e.sigma;
}

std::string error_of(const Measurement& m) {
    try {
        reduce(m);
    } catch (const InputError& e) {
        return e.what();
    }
    return "no error";
}

bool notes_say(const Reduction& r, const std::string& words) {
    for (const std::string& n : r.notes) {
        if (n.find(words) != std::string::npos) return true;
    }
    return false;
}

class LabSessionTest : public ::testing::Test {
protected:
    void SetUp() override {
        lab = lab_session(2.5e-6, 1);  // 0.01 px of 0.25 mm
        if (!lab && std::getenv("CI")) FAIL() << "the lab session's data are not there";
        if (!lab) GTEST_SKIP() << missing_data("lab-session");
    }
    std::optional<WrittenSession> lab;
};

TEST_F(LabSessionTest, SixPeriodsGiveTheTruth) {
    const Reduction r = reduce(lab->measurement);
    EXPECT_NEAR(r.v_D.value, lab->v_D, 0.01 * lab->v_D);
    EXPECT_NEAR(r.accelerometer_late_s.value, lab->late_s, 100e-6);
    EXPECT_NEAR(r.gamma.value, lab->gamma, 0.01 * lab->gamma);
    EXPECT_NEAR(r.phi.value, lab->phi, 0.01);
    EXPECT_NEAR(r.efficiency.value, lab->efficiency, 0.015 * lab->efficiency);
    ASSERT_GE(r.harmonics.size(), 3U);
    EXPECT_GT(r.harmonics[2].amplitude.value, 10 * r.harmonics[2].amplitude.sigma);
    EXPECT_EQ(r.frames, 600);
    EXPECT_TRUE(r.notes.empty()) << r.notes.front();
}

TEST_F(LabSessionTest, ErrorsCoverTheTruthOverManyNoises) {
    constexpr int runs = 40;
    int v = 0, late = 0, phi = 0, gamma = 0, ppm = 0;
    for (std::uint64_t seed = 0; seed < runs; ++seed) {
        const WrittenSession s = *lab_session(2.5e-6, seed);
        const Reduction r = reduce(s.measurement);
        v += std::abs(r.v_D.value - s.v_D) <= 2 * r.v_D.sigma;
        late += std::abs(r.accelerometer_late_s.value - s.late_s) <= 2 * r.accelerometer_late_s.sigma;
        ppm += std::abs(r.accelerometer_ppm.value - s.ppm) <= 2 * r.accelerometer_ppm.sigma;
        phi += std::abs(r.phi.value - s.phi) <= 3 * r.phi.sigma;
        gamma += std::abs(r.gamma.value - s.gamma) <= 3 * r.gamma.sigma;
    }
    EXPECT_GE(v, 35);  // 95 % of 40 is 38 +- 1.4
    EXPECT_GE(late, 35);
    EXPECT_GE(ppm, 35);
    EXPECT_GE(phi, 38);  // the accelerometer's file is one draw of its noise
    EXPECT_GE(gamma, 38);
}

TEST_F(LabSessionTest, FindsBriefStickOnlyWhereItIs) {
    for (const double noise : {2.5e-6, 0.3e-6, 0.05e-6}) {
        const Reduction r = reduce(lab_session(noise, 3)->measurement);
        for (const StickInterval& s : r.stick) {
            EXPECT_NEAR(s.from, lab->stick_from, std::max(3 * s.sd, 1e-3)) << noise;
            EXPECT_NEAR(s.to, lab->stick_to, std::max(3 * s.sd, 1e-3)) << noise;
        }
        EXPECT_LE(r.stick.size(), 1U);
        if (noise < 1e-6) {
            EXPECT_EQ(r.stick.size(), 1U) << noise;
        }
    }
}

TEST(ReductionTest, FortyPeriodsGiveTheTruthWithinTheirErrors) {
    SyntheticRun run;
    run.third = 0.29;
    run.views = 2;
    const Reduction r = reduce(make_measurement(run));
    expect_within(r.v_D, drift_velocity(run), 3, "v_D");
    expect_within(r.D, drift_velocity(run) / 20, 3, "D");
    expect_within(r.gamma, run.drive.gamma, 4, "gamma");
    expect_within(r.rho, 0.5, 4, "rho");
    expect_within(r.phi, 0, 4, "phi");
    expect_within(r.frequency, 20, 4, "frequency");
    expect_within(r.accelerometer_late_s, run.late_s, 4, "late");
    expect_within(r.accelerometer_ppm, run.ppm, 4, "ppm");
    expect_within(r.harmonics.at(2).amplitude, 0.29, 4, "third");
    EXPECT_LT(r.accelerometer_late_s.sigma, 10e-6);
    EXPECT_EQ(r.harmonics[0].phase.value, 0);
    const double w = two_pi * 20, V = run.drive.gamma / w;
    EXPECT_NEAR(r.v_rms.value, std::hypot(V * std::sqrt(5.0 / 32), 0.29 / (3 * w) / std::sqrt(2)), 1e-4 * V);
    EXPECT_NEAR(r.efficiency.value, drift_velocity(run) / r.v_rms.value, 1e-3);
    for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(r.shaker_axis[i], run.axis[i], 1e-4);
    EXPECT_TRUE(r.notes.empty()) << r.notes.front();
}

TEST(ReductionTest, PeriodsCarryDriftGammaAndPhi) {
    SyntheticRun run;
    run.drift_jitter = 0.02;
    const Reduction r = reduce(make_measurement(run));
    ASSERT_GE(r.periods.size(), 38U);
    double sum = 0;
    int n = 0;
    for (const PeriodResult& p : r.periods) {
        if (std::isfinite(p.gamma.value)) expect_within(p.gamma, run.drive.gamma, 5, "gamma of a period");
        if (std::isfinite(p.phi.value)) expect_within(p.phi, 0, 5, "phi of a period");
        if (!std::isfinite(p.drift.value)) continue;
        EXPECT_NEAR(p.drift.value, drift_velocity(run) / 20, 6 * 0.02 * drift_velocity(run) / 20);
        sum += p.drift.value;
        ++n;
    }
    EXPECT_TRUE(std::isnan(r.periods.front().drift.value));
    EXPECT_NEAR(sum / n, r.D.value, 3 * r.D.sigma);
}

TEST(ReductionTest, CycleHasVelocityAndNoStickAtCrossing) {
    SyntheticRun run;
    run.periods = 60;
    const Reduction r = reduce(make_measurement(run));
    const Cycle& c = r.cycle;
    ASSERT_EQ(c.phase.size(), 50U);
    EXPECT_TRUE(r.stick.empty());
    double mean = 0;
    int steep = 0;
    for (std::size_t i = 0; i < c.phase.size(); ++i) {
        mean += c.v_mps[i] / 50;
        const double slope = (c.v_mps[(i + 1) % 50] - c.v_mps[(i + 49) % 50]) / 2e-3;
        steep += std::abs(std::abs(slope) - 0.113 * paper_g) < 0.25 * 0.113 * paper_g;
        EXPECT_GT(c.v_sd_mps[i], 1e-5);
        EXPECT_LT(c.v_sd_mps[i], 1e-3);
    }
    EXPECT_NEAR(mean, drift_velocity(run), 2e-4);
    EXPECT_GE(steep, 36);  // slip at +-mu g everywhere but within 3 frames of the two kinks
}

class LengthTest : public ::testing::TestWithParam<int> {};

TEST_P(LengthTest, FindsLagToTenMicroseconds) {
    for (const double late : {0.0123, -0.0191, 0.0}) {
        SyntheticRun run;
        run.periods = GetParam();
        run.late_s = late;
        run.ppm = -80;
        const Reduction r = reduce(make_measurement(run));
        EXPECT_NEAR(r.accelerometer_late_s.value, late, 100e-6);
        expect_within(r.accelerometer_late_s, late, 4, "late");
        EXPECT_LT(r.accelerometer_late_s.sigma, GetParam() >= 6 ? 10e-6 : 40e-6);
        expect_within(r.phi, 0, 4, "phi");
    }
}

INSTANTIATE_TEST_SUITE_P(Periods, LengthTest, ::testing::Values(3, 6, 20, 100));

TEST(ReductionTest, ToleratesWrongNominalFrequencyInLongRun) {
    SyntheticRun run;
    run.periods = 400;
    Measurement m = make_measurement(run);
    m.frequency_hz = 20 * (1 + 400e-6);
    const Reduction r = reduce(m);
    expect_within(r.frequency, 20, 4, "frequency");
    EXPECT_LT(r.frequency.sigma, 20e-6);
    expect_within(r.v_D, drift_velocity(run), 3, "v_D");
}

TEST(ReductionTest, AnExactFrequencyIsKeptToTheBit) {
    Measurement m = make_measurement({});
    m.frequency_is_exact = true;
    const Reduction r = reduce(m);
    EXPECT_EQ(r.frequency.value, 20.0);
    EXPECT_EQ(r.frequency.sigma, 0.0);
    expect_within(r.accelerometer_ppm, 20, 4, "ppm");
}

TEST(ReductionTest, ReportsCameraScaleErrorWithoutChangingGamma) {
    SyntheticRun run;
    run.track_scale = 1.03;
    const Reduction r = reduce(make_measurement(run));
    EXPECT_TRUE(notes_say(r, "camera scale"));
    EXPECT_NEAR(r.gamma.value, run.drive.gamma, 1e-3 * run.drive.gamma);
}

TEST(ReductionTest, FindsAxisSignFromShapeForAnyMounting) {
    for (const std::array<double, 3>& axis : {std::array{-0.6, 0.8, 0.0}, std::array{0.0, 0.0, -1.0}}) {
        SyntheticRun run;
        run.axis = axis;
        run.periods = 12;
        const Reduction r = reduce(make_measurement(run));
        for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(r.shaker_axis[i], axis[i], 1e-3);
        expect_within(r.accelerometer_late_s, run.late_s, 4, "late");
    }
}

TEST(ReductionTest, ReversesBackwardAxisWithNote) {
    SyntheticRun run;
    Measurement m = make_measurement(run);
    m.accelerometer.shaker_axis = {-run.axis[0], -run.axis[1], -run.axis[2]};
    const Reduction r = reduce(m);
    EXPECT_TRUE(notes_say(r, "its sign was reversed"));
    expect_within(r.accelerometer_late_s, run.late_s, 4, "late");
}

TEST(ReductionTest, AlignsSingleHarmonicByShorterLagWithNote) {
    SyntheticRun run;
    run.drive.rho = 0.999;  // what is left of the second does not stand out
    run.drive.gamma = 3 * paper_g;
    run.position_noise_m = 10e-6;
    run.periods = 20;
    const Reduction r = reduce(make_measurement(run));
    expect_within(r.accelerometer_late_s, run.late_s, 4, "late");
    EXPECT_TRUE(notes_say(r, "sign of the shaker axis"));
}

TEST(ReductionTest, AlignsLooseClockNearestToZeroWithNote) {
    Measurement m = make_measurement({});
    m.accelerometer.clock_uncertainty_s = 0.2;
    const Reduction r = reduce(m);
    EXPECT_TRUE(notes_say(r, "nearest to zero"));
    EXPECT_NEAR(r.accelerometer_late_s.value, 0.0123, 1e-4);
}

TEST(ReductionTest, ExcludesCountsAndReportsLostFrames) {
    SyntheticRun run;
    Measurement m = make_measurement(run);
    MotionSeries& w = m.walkers[0];
    const auto lose = [&](std::size_t from, std::size_t n) {
        for (auto* list : {&w.t_s, &w.x_m, &w.sd_m}) {
            list->erase(list->begin() + static_cast<std::ptrdiff_t>(from),
                        list->begin() + static_cast<std::ptrdiff_t>(from + n));
        }
        w.lost += static_cast<int>(n);
    };
    lose(1500, 120);
    lose(700, 13);
    lose(100, 1);
    const Reduction r = reduce(m);
    EXPECT_EQ(r.frames, 2000 - 134);
    EXPECT_EQ(r.frames_lost, 134);
    EXPECT_TRUE(notes_say(r, "134 of 2000 frames"));
    expect_within(r.v_D, drift_velocity(run), 3, "v_D");
}

TEST(ReductionTest, ReducesRequestedPartOnly) {
    SyntheticRun run;
    Measurement m = make_measurement(run);
    for (std::size_t i = 0; i < 600; ++i)
        m.walkers[0].x_m[i] += 1e-3;  // something else happened before 0.6 s
    m.from_s = 0.62;
    m.to_s = 1.9;
    const Reduction r = reduce(m);
    EXPECT_EQ(r.frames, 1280);
    expect_within(r.v_D, drift_velocity(run), 3, "v_D");
    EXPECT_GE(r.t0_s, 0.61);
}

TEST(ReductionTest, IsDeterministic) {
    const Measurement m = make_measurement({});
    const Reduction a = reduce(m), b = reduce(m);
    EXPECT_EQ(a.v_D.value, b.v_D.value);
    EXPECT_EQ(a.v_D.sigma, b.v_D.sigma);
    EXPECT_EQ(a.cycle.v_mps, b.cycle.v_mps);
    EXPECT_EQ(a.accelerometer_late_s.value, b.accelerometer_late_s.value);
}

TEST(ReductionErrorTest, NamesStreamsWithLessThanTwoCommonPeriods) {
    Measurement m = make_measurement({});
    m.to_s = 0.08;
    EXPECT_NE(error_of(m).find("walker and base have 1.6"), std::string::npos) << error_of(m);
    m = make_measurement({});
    for (double& t : m.accelerometer.t_s) t += 1.95;
    EXPECT_NE(error_of(m).find("cameras and accelerometer have"), std::string::npos) << error_of(m);
    m = make_measurement({});
    for (double& t : m.bases[0].t_s) t += 10;
    EXPECT_NE(error_of(m).find("walker and base have 0 drive periods"), std::string::npos) << error_of(m);
}

TEST(ReductionErrorTest, TwoPeriodsAreEnough) {
    SyntheticRun run;
    run.periods = 2;
    const Reduction r = reduce(make_measurement(run));
    EXPECT_NEAR(r.v_D.value, drift_velocity(run), 0.01 * drift_velocity(run));
    EXPECT_TRUE(notes_say(r, "too few"));
}

TEST(ReductionErrorTest, NamesMissingOrInvalidStreams) {
    Measurement m = make_measurement({});
    m.walkers.clear();
    EXPECT_NE(error_of(m).find("no walker"), std::string::npos) << error_of(m);
    m = make_measurement({});
    m.bases.clear();
    EXPECT_NE(error_of(m).find("no base"), std::string::npos) << error_of(m);
    m = make_measurement({});
    m.accelerometer = {};
    EXPECT_NE(error_of(m).find("no accelerometer"), std::string::npos) << error_of(m);
    m = make_measurement({});
    m.walkers[0].x_m[77] = NAN;
    EXPECT_NE(error_of(m).find("walker in view 'top': position 77"), std::string::npos) << error_of(m);
    m = make_measurement({});
    m.accelerometer.a_mps2[5][1] = INFINITY;
    EXPECT_NE(error_of(m).find("accelerometer: sample 5"), std::string::npos) << error_of(m);
    m = make_measurement({});
    m.bases[0].t_s[9] = m.bases[0].t_s[8];
    EXPECT_NE(error_of(m).find("base in view 'top': time 9"), std::string::npos) << error_of(m);
    m = make_measurement({});
    m.walkers[0].sd_m.pop_back();
    EXPECT_NE(error_of(m).find("1999 standard deviations"), std::string::npos) << error_of(m);
    m = make_measurement({});
    m.frequency_hz = 0;
    EXPECT_NE(error_of(m).find("drive frequency"), std::string::npos) << error_of(m);
}

TEST(ReductionErrorTest, RefusesTooFewFramesPerPeriod) {
    SyntheticRun run;
    run.frame_rate_hz = 50;
    EXPECT_NE(error_of(make_measurement(run)).find("too few frames: 2.5"), std::string::npos);
}

TEST(ReductionCostTest, ReducesTwoViewsInUnderATenthOfASecond) {
    SyntheticRun run;
    run.views = 2;
    const Measurement m = make_measurement(run);
    double best = 1e9;
    for (int i = 0; i < 5; ++i) {
        const auto start = std::chrono::steady_clock::now();
        reduce(m);
        best =
            std::min(best, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
    }
    std::cout << "reduce(): " << 1e3 * best << " ms for 2 x 2000 frames and 8000 samples\n";
#ifdef NDEBUG
    EXPECT_LT(best, 0.1);
#endif
}

// On one card the rate is no unknown: it has no error, and the other results are as true as with a fitted
// one.
TEST(ReductionTest, OneClockForDriveAndSensorHasNoRateToFit) {
    SyntheticRun run;
    run.ppm = 0;
    Measurement m = make_measurement(run);
    m.frequency_is_exact = true;
    m.accelerometer.dac_clock = true;
    const Reduction r = reduce(m);
    EXPECT_EQ(r.accelerometer_ppm.value, 0);
    EXPECT_EQ(r.accelerometer_ppm.sigma, 0);
    EXPECT_NEAR(r.gamma.value, run.drive.gamma, 4 * r.gamma.sigma);
    EXPECT_NEAR(r.phi.value, run.drive.phi, 4 * r.phi.sigma);
    EXPECT_NEAR(r.v_D.value, drift_velocity(run), 4 * r.v_D.sigma);
    EXPECT_NEAR(r.accelerometer_late_s.value, run.late_s, 4 * r.accelerometer_late_s.sigma);
}

}  // namespace
}  // namespace shaker::reduction

// The accelerometer's lower corner by the phases of both instruments; the alarm of a phase that differs.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "daemon/reduction/reduction.hpp"
#include "tests/support/run/synthetic_run.hpp"

namespace shaker::reduction {
namespace {

constexpr double unknown = std::numeric_limits<double>::infinity();

/// A sensor without gravity in its reading.
Measurement ac_coupled(const SyntheticRun& run, const LowerCorner& told) {
    Measurement m = make_measurement(run);
    m.accelerometer.gravity = false;
    m.accelerometer.axes = 1;
    m.accelerometer.response.lower = told;
    for (auto& a : m.accelerometer.a_mps2) a[1] = a[2] = 0;
    m.accelerometer.shaker_axis = {1, 0, 0};
    return m;
}

struct Counted {
    int of = 0, corner = 0, phi = 0, late = 0, gamma = 0;
    double phi2 = 0, claimed2 = 0, off = 0;
    void add(const Reduction& r, const SyntheticRun& run) {
        const auto inside = [](const calibration::Estimate& e, double truth) {
            return std::abs(e.value - truth) < 2 * e.sigma;
        };
        const double turned = std::remainder(r.phi.value - run.drive.phi, two_pi);
        ++of;
        corner += inside(r.corner.hz, run.corner.hz);
        phi2 += turned * turned;
        off += turned;
        const double error = std::hypot(r.phi.sigma, std::isnan(r.systematic.phi) ? 0 : r.systematic.phi);
        claimed2 += error * error;
        phi += std::abs(turned) < 2 * error;
        late += inside(r.accelerometer_late_s, run.late_s);
        gamma += inside(r.gamma, run.drive.gamma);
    }
    void print(const char* name) const {
        std::printf(
            "%-22s corner %3d of %d inside two errors, phi %3d: rms %.2f mrad, claimed %.2f, mean %+.2f; "
            "gamma %d, lag %d\n",
            name, corner, of, phi, 1e3 * std::sqrt(phi2 / of), 1e3 * std::sqrt(claimed2 / of), 1e3 * off / of,
            gamma, late);
    }
};

SyntheticRun drawn(std::mt19937_64& random, std::uint64_t seed) {
    const auto uniform = [&](double a, double b) { return std::uniform_real_distribution{a, b}(random); };
    SyntheticRun run{.views = 2, .seed = seed};
    run.drive = {20, uniform(1, 2) * paper_g, 0.5, uniform(-0.4, 0.4)};
    run.axis = {1, 0, 0};
    run.accel_noise_mps2 = 1.1e-3 * std::exp(uniform(0, 2.3));
    run.corner.hz = 0.05 * std::exp(uniform(0, std::log(60.0)));
    return run;
}

constexpr int draws = 100, least = 90;  // 95.4 % of 100, 2.5 binomial standard deviations

TEST(CornerTest, CamerasShowACornerThatNobodyTold) {
    std::mt19937_64 random{11};
    Counted seen;
    for (std::uint64_t i = 0; i < draws; ++i) {
        const SyntheticRun run = drawn(random, i);
        const Reduction r = reduce(ac_coupled(run, {.error_hz = unknown, .poles = 0}));
        EXPECT_FALSE(r.gain_ratio.alarm || r.degraded) << run.corner.hz;
        EXPECT_TRUE(std::isnan(r.corner.phi_off.value));
        seen.add(r, run);
    }
    seen.print("not told");
    EXPECT_GE(seen.corner, least);
    EXPECT_GE(seen.phi, least);
    EXPECT_GE(seen.gamma, least);
    EXPECT_GE(seen.late, least);
    EXPECT_LT(std::sqrt(seen.phi2 / seen.of), 1.7e-3);
    EXPECT_NEAR(seen.phi2 / seen.claimed2, 1, 0.35);
}

TEST(CornerTest, ADataSheetIsWeighedWithTheCameras) {
    std::mt19937_64 random{12};
    std::normal_distribution<double> normal;
    Counted seen;
    int alarms = 0;
    for (std::uint64_t i = 0; i < draws; ++i) {
        const SyntheticRun run = drawn(random, i);
        const double error = 0.1 * run.corner.hz;
        const Reduction r =
            reduce(ac_coupled(run, {.hz = run.corner.hz + error * normal(random), .error_hz = error}));
        alarms += r.gain_ratio.alarm ? 1 : 0;
        seen.add(r, run);
    }
    seen.print("told, 10 % off");
    EXPECT_EQ(alarms, 0);
    EXPECT_GE(seen.phi, least);
    EXPECT_NEAR(seen.phi2 / seen.claimed2, 1, 0.35);
}

TEST(CornerTest, AWrongDataSheetAlarmsAndTheCamerasDecide) {
    SyntheticRun run{.views = 2, .axis = {1, 0, 0}};
    run.corner.hz = 0.5;
    const Reduction r = reduce(ac_coupled(run, {.hz = 0.1, .error_hz = 0.01}));
    EXPECT_TRUE(r.gain_ratio.alarm);
    EXPECT_EQ(doubts_of(r).size(), 1U);
    EXPECT_NEAR(r.corner.hz.value, 0.5, 4 * r.corner.hz.sigma);
    EXPECT_NEAR(r.phi.value, 0, 4 * r.phi.sigma);
    EXPECT_NEAR(r.corner.phi_off.value, 1.5 * 0.4 / 20, 4 * r.corner.phi_off.sigma);
}

TEST(CornerTest, ACalibratedCornerCostsHardlyMoreThanTheNoise) {
    SyntheticRun run{.views = 2, .axis = {1, 0, 0}};
    run.corner.hz = 0.33;
    const Reduction r = reduce(ac_coupled(run, {.hz = 0.33, .error_hz = 0.002}));
    EXPECT_LT(std::hypot(r.phi.sigma, r.systematic.phi), 0.3e-3);
    EXPECT_NEAR(r.phi.value, 0, 3 * std::hypot(r.phi.sigma, r.systematic.phi));
}

TEST(CornerTest, TwoPolesAreToldOrFitted) {
    SyntheticRun run{.views = 2, .axis = {1, 0, 0}};
    run.corner = {.hz = 1, .poles = 2};
    for (const LowerCorner& told :
         {LowerCorner{.hz = 1, .error_hz = 0.1, .poles = 2}, LowerCorner{.error_hz = unknown, .poles = 2},
          LowerCorner{.error_hz = unknown, .poles = 0}}) {
        const Reduction r = reduce(ac_coupled(run, told));
        EXPECT_NEAR(r.phi.value, 0,
                    3 * std::hypot(r.phi.sigma, std::isfinite(told.error_hz) ? r.systematic.phi : 0))
            << told.poles;
        EXPECT_NEAR(r.gamma.value, run.drive.gamma, 3 * r.gamma.sigma + 1e-4 * r.gamma.value) << told.poles;
    }
}

/// A sensor with gravity is coupled down to DC; its drive has no corner to take off.
TEST(CornerTest, ATurnedPhaseIsAnAlarm) {
    constexpr int runs = 100;
    int found = 0, wrong = 0;
    for (std::uint64_t i = 0; i < runs; ++i) {
        SyntheticRun run{.views = 2, .seed = i + 1};
        wrong += reduce(make_measurement(run)).gain_ratio.alarm ? 1 : 0;
        run.corner.hz = 0.12;
        const Reduction r = reduce(make_measurement(run));
        EXPECT_TRUE(std::isnan(r.corner.hz.value));
        found += r.gain_ratio.alarm ? 1 : 0;
        if (i == 0)
            std::printf("phi off by %+.2f +- %.2f mrad (9 are true)\n", 1e3 * r.corner.phi_off.value,
                        1e3 * r.corner.phi_off.sigma);
    }
    std::printf("9 mrad: found in %d of %d; false alarms %d\n", found, runs, wrong);
    EXPECT_GE(found, 99);
    EXPECT_EQ(wrong, 0);
}

TEST(CornerTest, ASingleHarmonicShowsNoCorner) {
    SyntheticRun run{.views = 2, .axis = {1, 0, 0}};
    run.drive.rho = 1;
    run.may_stick = true;
    run.corner.hz = 0.5;
    const Reduction r = reduce(ac_coupled(run, {.error_hz = unknown, .poles = 0}));
    EXPECT_TRUE(r.corner.unknown);
    ASSERT_EQ(doubts_of(r).size(), 1U) << "it reaches mu and the law of friction";
    EXPECT_TRUE(
        doubts_of(r).front().starts_with("phi is not corrected for the accelerometer's lower corner"));
    const Reduction told = reduce(ac_coupled(run, {.hz = 0.5, .error_hz = 0.05}));
    EXPECT_FALSE(told.corner.unknown);
    EXPECT_NEAR(told.gamma.value, run.drive.gamma, 3 * told.gamma.sigma);
}

TEST(CornerTest, ACornerThatLowersTheDriveIsDegraded) {
    SyntheticRun run{.views = 2, .axis = {1, 0, 0}};
    run.corner.hz = 12;
    const Reduction r = reduce(ac_coupled(run, {.error_hz = unknown, .poles = 0}));
    EXPECT_TRUE(r.degraded);
    EXPECT_TRUE(std::ranges::any_of(
        r.notes, [](const std::string& n) { return n.find("lowers the drive's first harmonic") != n.npos; }));
}

/// As by a slip of the keyboard.
TEST(CornerTest, AToldCornerFarFromTheTruthEndsAtTheTruth) {
    SyntheticRun run{.views = 2, .axis = {1, 0, 0}};
    run.corner.hz = 0.33;
    for (const double told_hz : {3.3, 25.0, 33.0, 100.0}) {
        const Reduction r = reduce(ac_coupled(run, {.hz = told_hz, .error_hz = 0.1 * told_hz}));
        EXPECT_TRUE(r.gain_ratio.alarm) << told_hz;
        EXPECT_NEAR(r.corner.hz.value, 0.33, 4 * r.corner.hz.sigma) << told_hz;
        EXPECT_NEAR(r.phi.value, 0, 4 * r.phi.sigma) << told_hz;
    }
}

// A sensor with gravity and a low-pass of 150 Hz, which turns phi by 6.7 mrad.
TEST(CornerTest, AToldLowPassIsTakenOff) {
    std::mt19937_64 random{3};
    SyntheticRun run = drawn(random, 3);
    run.corner = {};
    run.lowpass_hz = 150;
    Measurement m = make_measurement(run);
    const Reduction without = reduce(m);
    EXPECT_TRUE(without.corner.alarm);
    m.accelerometer.response.upper = {.hz = 150, .error_hz = 3};
    const Reduction with = reduce(m);
    EXPECT_FALSE(with.corner.alarm);
    EXPECT_NEAR(without.phi.value - with.phi.value, phi_turned(LowPass{.hz = 150}, 20), 1e-6);
    EXPECT_NEAR(with.phi.value, run.drive.phi, 4 * std::hypot(with.phi.sigma, with.systematic.phi));
    EXPECT_NEAR(with.systematic.phi, 3 * 6.7e-3 * 3 / 150, 1e-4);
    EXPECT_GT(with.gamma.value, without.gamma.value);
}

}  // namespace
}  // namespace shaker::reduction

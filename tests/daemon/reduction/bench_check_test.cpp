// Gain of the cameras over the accelerometer, tilt, and the shares of the calibrations in the results.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "daemon/reduction/reduction.hpp"
#include "drivers/walker/steady_state.hpp"
#include "tests/support/run/synthetic_run.hpp"

namespace shaker::reduction {
namespace {

constexpr double slope = 0.2 * two_pi / 360;  // rad

std::size_t notes_with(const Reduction& r, const std::string& words) {
    return static_cast<std::size_t>(std::ranges::count_if(
        r.notes, [&](const std::string& n) { return n.find(words) != std::string::npos; }));
}

void set_scale_error(Measurement& m, double error) {
    for (auto* views : {&m.walkers, &m.bases})
        for (MotionSeries& v : *views) v.scale_error = error;
}

/// A calibration with this relative error of each gain and this error of each offset, m/s^2.
calibration::Tumble tumble(double gain, double offset_mps2) {
    calibration::Tumble t{.gravity = {9.8, 0}};
    for (std::size_t i = 0; i < 9; ++i) {
        const double error = i < 3 ? gain : i < 6 ? 0 : offset_mps2 / 9.8;
        t.covariance[10 * i] = error * error;
    }
    return t;
}

/// Adds a constant acceleration along the shaker's axis.
void lean(Measurement& m, const std::array<double, 3>& axis, double mps2) {
    for (auto& a : m.accelerometer.a_mps2)
        for (std::size_t k = 0; k < 3; ++k) a[k] += mps2 * axis[k];
}

TEST(BenchCheckTest, ErrorsCoverTheTruthOverManyNoises) {
    constexpr int draws = 150;
    SyntheticRun run{.periods = 16, .views = 2, .track_scale = 1.003};
    int one = 0, two = 0, side = 0, shape = 0, delay = 0;
    double chi2 = 0, claimed = 0;
    for (int i = 0; i < draws; ++i) {
        run.seed = static_cast<std::uint64_t>(i + 1);
        const GainRatio r = reduce(make_measurement(run)).gain_ratio;
        const double z = (r.ratio.value - run.track_scale) / r.ratio.sigma;
        chi2 += z * z / draws;
        claimed += r.ratio.sigma / draws;
        one += std::abs(z) < 1;
        two += std::abs(z) < 2;
        side += std::abs(r.views[1].ratio.value - run.track_scale) < 2 * r.views[1].ratio.sigma;
        shape += std::abs(r.second_over_first.value - 1) < 2 * r.second_over_first.sigma;
        delay += std::abs(r.at[0].delay_s.value) < 2 * r.at[0].delay_s.sigma;
    }
    std::printf(
        "camera/accelerometer: claimed %.2e; of %d within 1 sigma %d, 2 sigma %d, z rms %.2f; side %d, "
        "2w over w %d within 2 sigma\n",
        claimed, draws, one, two, std::sqrt(chi2), side, shape);
    // Binomial, three standard deviations: 68.3 % of 150 are 102 +- 17, 95.4 % are 143 +- 8.
    EXPECT_NEAR(one, 102, 17);
    EXPECT_GE(two, 135);
    EXPECT_GE(side, 135);
    EXPECT_GE(shape, 135);
    EXPECT_GE(delay, 135);
    EXPECT_LT(claimed, 5e-4);
}

TEST(BenchCheckTest, AlarmsAtFourStandardErrors) {
    SyntheticRun run{.views = 2};
    EXPECT_EQ(notes_with(reduce(make_measurement(run)), "bench check"), 0U);
    run.track_scale = 1.0085;
    const Reduction r = reduce(make_measurement(run));
    EXPECT_EQ(notes_with(r, "camera scale or sensor gain is off by 0.8"), 2U) << r.notes.front();
    EXPECT_EQ(notes_with(r, "no systematic error is known"), 2U);
    EXPECT_TRUE(std::isnan(r.gain_ratio.systematic));
}

TEST(BenchCheckTest, KnownErrorsBelongToTheAlarm) {
    Measurement m = make_measurement({.track_scale = 1.0085});
    set_scale_error(m, 0.004);
    EXPECT_EQ(notes_with(reduce(m), "bench check"), 0U);
    EXPECT_NEAR(reduce(m).gain_ratio.systematic, 0.004, 1e-9);
    set_scale_error(m, 1e-3);
    EXPECT_EQ(notes_with(reduce(m), "sensor gain (the camera's scale is calibrated)"), 1U);
    set_scale_error(m, 0);
    m.accelerometer.calibration = tumble(1e-4, 1e-4);
    EXPECT_EQ(notes_with(reduce(m), "camera scale (the accelerometer is calibrated)"), 1U);
}

TEST(BenchCheckTest, NamesTheViewThatIsWrong) {
    Measurement m = make_measurement({.views = 2});
    for (double& x : m.bases[1].x_m) x *= 1.0085;
    const Reduction r = reduce(m);
    EXPECT_EQ(notes_with(r, "bench check"), 1U);
    EXPECT_EQ(notes_with(r, "by camera \"side\""), 1U);
    EXPECT_EQ(notes_with(r, "camera scale (the other views agree"), 1U);
}

TEST(BenchCheckTest, ExposureIsCorrected) {
    Measurement m = make_measurement({.position_noise_m = 2e-7, .accel_noise_mps2 = 1e-4});
    const double w1 = reduce(m).gain_ratio.ratio.value;
    m.bases[0].exposure_s = 2e-3;
    const GainRatio r = reduce(m).gain_ratio;
    // sin(x)/x at x = pi q f T: 0.26 % at 20 Hz, 1.05 % at 40 Hz.
    EXPECT_NEAR(r.at[0].ratio.value, w1 * 1.00264, 2e-4);
    EXPECT_NEAR(r.at[1].ratio.value, w1 * 1.01060, 5e-4);
    EXPECT_NEAR(r.second_over_first.value, 1.00794, 5e-4);
    EXPECT_EQ(notes_with(reduce(m), "which no gain explains"), 1U);
}

TEST(BenchCheckTest, TiltAndItsShareAreReported) {
    const SyntheticRun run;
    Measurement m = make_measurement(run);
    lean(m, run.axis, -9.8 * std::tan(slope));
    m.accelerometer.calibration = tumble(1e-4, 1e-3);
    const Reduction r = reduce(m);
    EXPECT_NEAR(r.tilt.angle.sigma, 1e-3 / 9.8, 0.3e-4);
    EXPECT_NEAR(r.tilt.angle.value, slope, 4 * r.tilt.noise);
    EXPECT_NEAR(r.tilt.mu, 0.113, 0.006);
    walker::WalkerSetting law{.frequency = run.drive.frequency, .base = harmonics(run.drive)};
    const double level = settle(walker::WalkerLaw{law}).v_D;
    law.tilt = slope;
    const double share = settle(walker::WalkerLaw{law}).v_D - level;
    EXPECT_NEAR(r.tilt.v_D.value, share, 0.1 * share);
    EXPECT_LT(std::abs(r.tilt.v_D.value - share), 2 * r.tilt.v_D.sigma);
    EXPECT_EQ(notes_with(r, "gravity shows a tilt of +3.4"), 1U);
    EXPECT_EQ(notes_with(r, "level the base"), 1U);
}

TEST(BenchCheckTest, TiltWithoutCalibrationHasNoError) {
    const SyntheticRun run;
    Measurement m = make_measurement(run);
    EXPECT_EQ(notes_with(reduce(m), "tilt"), 0U);
    lean(m, run.axis, -9.8 * std::tan(slope));
    const Reduction r = reduce(m);
    EXPECT_NEAR(r.tilt.angle.value, slope, 4 * r.tilt.noise);
    EXPECT_TRUE(std::isnan(r.tilt.angle.sigma));
    EXPECT_EQ(notes_with(r, "if the accelerometer has no offset"), 1U);
    for (auto& a : m.accelerometer.a_mps2) a[2] -= 9.8;  // a sensor that does not measure a constant
    EXPECT_TRUE(std::isnan(reduce(m).tilt.angle.value));
}

TEST(BenchCheckTest, CalibrationsHaveTheirShareInTheErrors) {
    Measurement m = make_measurement({.views = 2});
    const Reduction plain = reduce(m);
    for (const double s : {plain.systematic.v_D, plain.systematic.D, plain.systematic.gamma,
                           plain.systematic.v_rms, plain.systematic.efficiency})
        EXPECT_TRUE(std::isnan(s));
    set_scale_error(m, 2e-3);
    m.accelerometer.calibration = tumble(1e-3, 1e-3);
    const Reduction r = reduce(m);
    const double gain = m.accelerometer.calibration->gain_error(r.shaker_axis);
    EXPECT_NEAR(r.systematic.v_D, 2e-3 * std::abs(r.v_D.value), 1e-9);
    EXPECT_NEAR(r.systematic.D, r.systematic.v_D / r.frequency.value, 1e-9);
    EXPECT_NEAR(r.systematic.gamma, gain * r.gamma.value, 1e-9);
    EXPECT_NEAR(r.systematic.v_rms, gain * r.v_rms.value, 1e-9);
    EXPECT_NEAR(r.systematic.efficiency, std::hypot(2e-3, gain) * r.efficiency.value, 1e-9);
    EXPECT_EQ(r.v_D.sigma, plain.v_D.sigma);
    EXPECT_EQ(r.v_D.value, plain.v_D.value);
    m.walkers[1].scale_error = 0;  // one view is not calibrated
    EXPECT_TRUE(std::isnan(reduce(m).systematic.v_D));
}

TEST(BenchCheckTest, BenchAtRestHasNoRatio) {
    SyntheticRun run;
    run.drive.gamma = 1e-4;
    run.may_stick = true;
    const Reduction r = reduce(make_measurement(run));
    EXPECT_TRUE(r.gain_ratio.at.empty());
    EXPECT_TRUE(std::isnan(r.gain_ratio.ratio.value));
    EXPECT_EQ(notes_with(r, "bench check"), 0U);
}

}  // namespace
}  // namespace shaker::reduction

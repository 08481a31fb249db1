// Bad accelerometer samples in complete reductions.
#include "daemon/reduction/bad_samples.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "daemon/reduction/reduction.hpp"
#include "drivers/errors.hpp"
#include "tests/support/run/synthetic_run.hpp"

namespace shaker::reduction {
namespace {

bool notes_say(const Reduction& r, const std::string& words) {
    return std::ranges::any_of(r.notes,
                               [&](const std::string& n) { return n.find(words) != std::string::npos; });
}

void expect_true_motion(const Reduction& r, const SyntheticRun& run) {
    EXPECT_LT(std::abs(r.gamma.value - run.drive.gamma), 4 * r.gamma.sigma) << r.gamma.value;
    EXPECT_LT(r.gamma.sigma, 1e-3 * run.drive.gamma);
    EXPECT_LT(std::abs(r.accelerometer_late_s.value - run.late_s), 4 * r.accelerometer_late_s.sigma);
    EXPECT_LT(std::abs(r.v_D.value - drift_velocity(run)), 3 * r.v_D.sigma);
}

// Samples from `first` on, `count` of them, repeat the one before on a sensor axis.
void freeze(AccelSeries& s, std::size_t axis, std::size_t first, std::size_t count) {
    for (std::size_t i = first; i < first + count; ++i) s.a_mps2[i][axis] = s.a_mps2[first - 1][axis];
}

TEST(BadSamplesTest, SoundSamplesAreAlignedOnce) {
    Measurement m = make_measurement({});
    std::vector<std::string> notes, plain_notes;
    BadSamples bad;
    const Alignment plain = align(m, plain_notes), drive = align_without_bad_samples(m, bad, notes);
    EXPECT_EQ(bad.count(), 0U);
    EXPECT_EQ(bad.tested, drive.t_s.size());
    EXPECT_EQ(drive.acceleration.a, plain.acceleration.a);
    EXPECT_EQ(drive.late_s.value, plain.late_s.value);
    EXPECT_EQ(notes, plain_notes);
}

class OneBadSampleTest : public ::testing::TestWithParam<double> {};

TEST_P(OneBadSampleTest, LeavesTheResultsRight) {
    SyntheticRun run;
    for (const std::size_t axis : {0U, 2U}) {
        Measurement m = make_measurement(run);
        m.accelerometer.a_mps2[4321][axis] = GetParam();
        const Reduction r = reduce(m);
        expect_true_motion(r, run);
        EXPECT_EQ(r.samples_bad, 1);
        EXPECT_FALSE(r.degraded);
        EXPECT_TRUE(r.notes.empty()) << r.notes.front();
    }
}

INSTANTIATE_TEST_SUITE_P(Sizes, OneBadSampleTest, ::testing::Values(30.0, 100.0, -1e6, 1e12));

TEST(BadSamplesTest, OneInShortRunIsNoted) {
    SyntheticRun run;
    run.periods = 4;
    Measurement m = make_measurement(run);
    m.accelerometer.a_mps2[432][0] = 100;
    const Reduction r = reduce(m);
    expect_true_motion(r, run);
    EXPECT_TRUE(notes_say(r, "1 of 8"));
    EXPECT_FALSE(r.degraded);
}

TEST(BadSamplesTest, HalfAPercentIsNotedAndExcluded) {
    SyntheticRun run;
    run.drive.gamma = paper_g;
    Measurement m = make_measurement(run);
    std::mt19937_64 random{7};
    std::uniform_real_distribution<double> value{-80, 80};
    for (int i = 0; i < 40; ++i) m.accelerometer.a_mps2[random() % 8000][0] = value(random);
    const Reduction r = reduce(m);
    expect_true_motion(r, run);
    EXPECT_GE(r.samples_bad, 30);
    EXPECT_TRUE(notes_say(r, "are bad"));
    EXPECT_FALSE(r.degraded);
}

TEST(BadSamplesTest, FortyMillisecondsFrozenAxisDegrade) {
    SyntheticRun run;
    Measurement m = make_measurement(run);
    freeze(m.accelerometer, 0, 3000, 160);
    const Reduction r = reduce(m);
    expect_true_motion(r, run);
    EXPECT_NEAR(r.samples_bad, 160, 2);
    EXPECT_TRUE(notes_say(r, "in frozen stretches"));
    EXPECT_TRUE(r.degraded);  // 2 %
}

TEST(BadSamplesTest, ThirdOfRecordFrozenDegrades) {
    SyntheticRun run;
    Measurement m = make_measurement(run);
    for (std::size_t axis = 0; axis < 3; ++axis) freeze(m.accelerometer, axis, 2000, 2667);
    const Reduction r = reduce(m);
    expect_true_motion(r, run);
    EXPECT_NEAR(r.samples_bad, 2667, 3);
    EXPECT_TRUE(r.degraded);
}

TEST(BadSamplesTest, MostlyFrozenSensorIsRefused) {
    Measurement m = make_measurement({});
    freeze(m.accelerometer, 0, 3000, 5100);
    try {
        reduce(m);
        FAIL() << "no error";
    } catch (const InputError& e) {
        EXPECT_NE(std::string{e.what()}.find("at most 50 % may be"), std::string::npos) << e.what();
    }
}

TEST(BadSamplesTest, SamePhaseDegrades) {
    SyntheticRun run;
    run.ppm = 0;
    for (const int periods : {3, 20}) {  // 3 of 8000 samples are fewer than 0.1 %
        Measurement m = make_measurement(run);
        for (int k = 0; k < periods; ++k)
            m.accelerometer.a_mps2[static_cast<std::size_t>(1000 + 200 * k)][0] += 40;
        const Reduction r = reduce(m);
        expect_true_motion(r, run);
        EXPECT_EQ(r.samples_bad, periods);
        EXPECT_TRUE(r.degraded);
        EXPECT_TRUE(notes_say(r, "same phase"));
    }
}

TEST(BadSamplesTest, RandomPhasesDoNotDegrade) {
    SyntheticRun run;
    run.periods = 100;
    int degraded = 0;
    for (unsigned seed = 0; seed < 10; ++seed) {
        Measurement m = make_measurement(run);
        std::mt19937_64 random{seed};
        for (int i = 0; i < 60; ++i) m.accelerometer.a_mps2[random() % 20000][0] += 50;
        degraded += reduce(m).degraded;
    }
    EXPECT_EQ(degraded, 0);
}

TEST(BadSamplesTest, CoarseSensorHasNoBadSamples) {
    SyntheticRun run;
    Measurement m = make_measurement(run);
    constexpr double lsb = 0.6;  // 8 bits, +-8 g
    for (auto& a : m.accelerometer.a_mps2)
        for (double& v : a) v = lsb * std::round(v / lsb);
    const Reduction r = reduce(m);
    EXPECT_EQ(r.samples_bad, 0);
    EXPECT_NEAR(r.gamma.value, run.drive.gamma, 0.01 * run.drive.gamma);
}

TEST(BadSamplesTest, NoiseOfSensorAtRestHasNone) {
    SyntheticRun run;
    run.drive.gamma = 1e-4;
    run.may_stick = true;
    EXPECT_EQ(reduce(make_measurement(run)).samples_bad, 0);
}

TEST(BadSamplesTest, GainNoteNamesTheOneWithBadResiduals) {
    SyntheticRun run;
    run.track_scale = 1.05;
    Measurement m = make_measurement(run);
    EXPECT_TRUE(notes_say(reduce(m), "camera scale or sensor gain is off"));
    std::mt19937_64 random{3};
    std::normal_distribution<double> noise{0, 20e-6};
    for (double& x : m.bases[0].x_m) x += noise(random);
    EXPECT_TRUE(notes_say(reduce(m), "camera scale (the tracks' residuals"));
    m = make_measurement(run);
    noise = std::normal_distribution<double>{0, 1.5};
    for (auto& a : m.accelerometer.a_mps2) a[0] += noise(random);
    EXPECT_TRUE(notes_say(reduce(m), "sensor gain (its residuals"));
}

}  // namespace
}  // namespace shaker::reduction

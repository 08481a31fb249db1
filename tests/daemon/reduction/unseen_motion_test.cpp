// Cameras with wrong times: the base's motion that the accelerometer measures is not where they show it.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "daemon/reduction/reduction.hpp"
#include "drivers/errors.hpp"
#include "tests/support/nightly.hpp"
#include "tests/support/run/synthetic_run.hpp"

namespace shaker::reduction {
namespace {

SyntheticRun drawn(std::mt19937_64& draw) {
    const auto between = [&](double low, double high) {
        return std::uniform_real_distribution(low, high)(draw);
    };
    SyntheticRun run;
    run.drive = {between(5, 40), between(1, 2) * paper_g, between(0.1, 0.9), 0.0};
    run.may_stick = true;
    run.frame_rate_hz = run.drive.frequency * between(8, 60);
    run.accel_rate_hz = 100 * run.drive.frequency;
    run.periods = static_cast<int>(between(12, 60));
    run.views = static_cast<int>(between(1, 2.99));
    run.position_noise_m = between(1e-6, 5e-6);
    run.seed = draw();
    return run;
}

/// The cameras' times `factor` times as long.
Measurement stretched(Measurement m, double factor) {
    for (auto* views : {&m.walkers, &m.bases})
        for (MotionSeries& v : *views)
            for (double& t : v.t_s) t *= factor;
    return m;
}

TEST(UnseenMotionTest, NoTimeFactorGivesAWrongVelocityWithoutAWord) {
    std::mt19937_64 draw(test::seed_of_day(1));
    int refused = 0, noted = 0, right = 0;
    const int count = test::plays(16, 600);
    for (int i = 0; i < count; ++i) {
        const SyntheticRun run = drawn(draw);
        const double factor = i % 4 == 0   ? 2
                              : i % 4 == 1 ? 0.5
                                           : std::exp(std::uniform_real_distribution(-1.2, 1.2)(draw));
        const double truth = drift_velocity(run);
        const Reduction sound = reduce(make_measurement(run));
        EXPECT_FALSE(sound.degraded) << "draw " << i << ": " << sound.notes.back();
        try {
            const Reduction r = reduce(stretched(make_measurement(run), factor));
            const bool is_right = std::abs(r.v_D.value - truth) < 5 * r.v_D.sigma,
                       has_note = r.degraded || r.notes.size() > sound.notes.size();
            right += is_right;
            noted += !is_right && has_note;
            EXPECT_TRUE(is_right || has_note)
                << "draw " << i << ": factor " << factor << ", rho " << run.drive.rho << ", "
                << run.drive.frequency << " Hz, v_D " << r.v_D.value << " for " << truth;
        } catch (const InputError&) {
            ++refused;
        }
    }
    std::printf("%d draws: %d refused, %d with a note, %d right\n", count, refused, noted, right);
}

TEST(UnseenMotionTest, TheNoteNamesBothFrequencies) {
    const Reduction r = reduce(stretched(make_measurement({.drive = {20, 1.5 * paper_g, 0.2, 0}}), 2));
    EXPECT_TRUE(r.degraded);
    ASSERT_FALSE(r.notes.empty());
    EXPECT_NE(r.notes.back().find("at 40 Hz"), std::string::npos) << r.notes.back();
    EXPECT_NE(r.notes.back().find("at 10 Hz"), std::string::npos) << r.notes.back();
}

TEST(UnseenMotionTest, AWrongNominalFrequencyIsDoubted) {
    for (const double times : {0.25, 1.0 / 3, 0.5, 1.0, 2.0, 3.0}) {
        Measurement m = make_measurement({.may_stick = true});
        m.frequency_hz *= times;
        try {
            const Reduction r = reduce(std::move(m));
            EXPECT_EQ(r.degraded, times != 1) << times;
            EXPECT_EQ(r.notes.empty(), times == 1) << times;
        } catch (const InputError&) {
            EXPECT_NE(times, 1);
        }
    }
}

}  // namespace
}  // namespace shaker::reduction

// Accelerometer clocks that drift, walk or run at a wrong rate, in alignments and complete reductions.
#include "daemon/reduction/clock_drift.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

#include "daemon/reduction/aligner.hpp"
#include "daemon/reduction/reduction.hpp"
#include "daemon/reduction/selection.hpp"
#include "drivers/errors.hpp"
#include "tests/support/run/synthetic_run.hpp"

namespace shaker::reduction {
namespace {

bool say(const std::vector<std::string>& notes, const std::string& words) {
    return std::ranges::any_of(notes,
                               [&](const std::string& n) { return n.find(words) != std::string::npos; });
}

// A run whose accelerometer stamps are `extra` s later than those of a straight clock.
struct Drifting {
    SyntheticRun run{};
    std::vector<double> master_s{}, extra_s{};  // of each sample

    Measurement measurement(const std::function<double(double master_s)>& extra) {
        Measurement m = make_measurement(run);
        master_s.clear();
        extra_s.clear();
        for (double& t : m.accelerometer.t_s) {
            master_s.push_back(t * (1 + 1e-6 * run.ppm) - run.late_s);
            extra_s.push_back(extra(master_s.back()));
            t += extra_s.back();
        }
        return m;
    }
    // Delay at master time t.
    [[nodiscard]] double delay_at(double t) const {
        const auto i = static_cast<std::size_t>(std::ranges::lower_bound(master_s, t) - master_s.begin());
        return run.late_s + extra_s.at(i) - 1e-6 * run.ppm * t;
    }
    // Largest error of the samples' master times.
    [[nodiscard]] double worst(const Alignment& a) const {
        double most = 0;
        for (std::size_t i = 0; i < a.t_s.size(); ++i)
            most = std::max(most, std::abs(a.t_s[i] - master_s.at(a.first_sample + i)));
        return most;
    }
};

std::function<double(double)> walk(double s_rts, double rate_hz, unsigned seed) {
    return [=, random = std::mt19937_64{seed}, at = 0.0](double) mutable {
        at += s_rts / std::sqrt(rate_hz) * std::normal_distribution<double>{}(random);
        return at;
    };
}

// Low rates make long records cheap.
SyntheticRun long_run(int periods) {
    SyntheticRun run;
    run.periods = periods;
    run.frame_rate_hz = 200;
    run.accel_rate_hz = 500;
    run.views = 1;
    return run;
}

double middle(const Alignment& a) { return (a.t_s.front() + a.t_s.back()) / 2; }

TEST(ClockDriftTest, GoodClockIsNotFollowed) {
    int followed = 0, covered = 0;
    for (unsigned seed = 1; seed <= 20; ++seed) {
        Drifting d;
        d.run.ppm = 0;
        d.run.seed = seed;
        std::vector<std::string> notes;
        const Alignment a = align(d.measurement([](double) { return 0; }), notes);
        followed += say(notes, "drifts");
        covered += std::abs(a.delay_s.value - d.run.late_s) < 2 * a.delay_s.sigma;
    }
    EXPECT_EQ(followed, 0);
    EXPECT_GE(covered, 17);
}

TEST(ClockDriftTest, FortyPeriodsGiveDelayToTwoMicroseconds) {
    double squares = 0;
    for (unsigned seed = 1; seed <= 20; ++seed) {
        Drifting d;
        d.run.drive.gamma = paper_g;
        d.run.views = 2;
        d.run.seed = seed;
        std::vector<std::string> notes;
        const Alignment a = align(d.measurement([](double) { return 0; }), notes);
        squares += std::pow(a.delay_s.value - d.delay_at(middle(a)), 2);
    }
    EXPECT_LT(std::sqrt(squares / 20), 2e-6);
}

TEST(ClockDriftTest, SixPpmInTenMinutesAreFollowed) {
    Drifting d{long_run(12000)};
    std::vector<std::string> notes;
    const Alignment a = align(d.measurement([](double t) { return 0.5e-8 * t * t; }), notes);
    EXPECT_TRUE(say(notes, "drifts"));
    EXPECT_LT(d.worst(a), 20e-6);  // 900 us off a straight line at the ends
    EXPECT_LT(std::abs(a.delay_s.value - d.delay_at(middle(a))), 3 * a.delay_s.sigma);
    EXPECT_LT(a.delay_s.sigma, 10e-6);
    EXPECT_LT(std::abs(a.ppm.value - (d.run.ppm - 3)), 3 * a.ppm.sigma);
}

TEST(ClockDriftTest, RandomWalkOverTenMinutesIsCovered) {
    int covered = 0, rate_covered = 0;
    for (unsigned seed = 1; seed <= 8; ++seed) {
        Drifting d{long_run(6000)};
        d.run.seed = seed;
        std::vector<std::string> notes;
        const Alignment a = align(d.measurement(walk(5e-6, d.run.accel_rate_hz, seed)), notes);
        EXPECT_TRUE(say(notes, "drifts"));
        EXPECT_LT(d.worst(a), 60e-6);
        covered += std::abs(a.delay_s.value - d.delay_at(middle(a))) < 2 * a.delay_s.sigma;
        rate_covered += std::abs(a.ppm.value - d.run.ppm) < 2 * a.ppm.sigma;
    }
    EXPECT_GE(covered, 6);
    EXPECT_GE(rate_covered, 6);
}

TEST(ClockDriftTest, RandomWalkInFortyPeriodsIsCovered) {
    int covered = 0;
    for (unsigned seed = 1; seed <= 20; ++seed) {
        Drifting d;
        d.run.views = 2;
        d.run.seed = seed;
        std::vector<std::string> notes;
        const Alignment a = align(d.measurement(walk(10e-6, d.run.accel_rate_hz, seed)), notes);
        covered += std::abs(a.delay_s.value - d.delay_at(middle(a))) < 2 * a.delay_s.sigma;
    }
    EXPECT_GE(covered, 16);
}

TEST(ClockDriftTest, SixtyPpmFor25MinutesKeepThePeriod) {
    Drifting d{long_run(30000)};
    d.run.ppm = 60;
    const Reduction r = reduce(d.measurement([](double) { return 0; }));
    EXPECT_LT(std::abs(r.accelerometer_late_s.value - d.run.late_s), 4 * r.accelerometer_late_s.sigma);
    EXPECT_NEAR(r.delay_s.value, d.run.late_s - 60e-6 * 750, 1e-5);
    EXPECT_FALSE(say(r.notes, "lags"));
}

class ToldRateTest : public ::testing::TestWithParam<double> {};

TEST_P(ToldRateTest, WrongRateIsNoted) {
    Measurement m = make_measurement({});
    for (auto* views : {&m.walkers, &m.bases})
        for (MotionSeries& s : *views)
            for (double& t : s.t_s) t *= 1 + GetParam();
    const Reduction r = reduce(m);
    EXPECT_TRUE(say(r.notes, "a crystal is within 400 ppm"));
    EXPECT_TRUE(say(r.notes, "The frame rate in the settings is off by")) << "two of three clocks agree";
    EXPECT_LT(std::abs(r.v_D.value - drift_velocity({})), 2 * r.v_D.sigma);
    EXPECT_LT(std::abs(r.frequency.value - SyntheticRun{}.drive.frequency), 2 * r.frequency.sigma);
    EXPECT_FALSE(r.gain_ratio.alarm) << "no other instrument is named";
    EXPECT_FALSE(say(r.notes, "mm_per_px"));
    EXPECT_EQ(doubts_of(r).size(), 1U) << "campaign, mu and law name it";
}

// The sensor's sample rate in the settings is wrong: v_D does not depend on it.
TEST(ToldSampleRateTest, LeavesTheErrorOfTheDrift) {
    SyntheticRun run;
    const double sigma = reduce(make_measurement(run)).v_D.sigma;
    run.ppm = 5000;
    const Reduction r = reduce(make_measurement(run));
    EXPECT_TRUE(say(r.notes, "The sample rate in the settings is off"));
    EXPECT_LT(r.v_D.sigma, 1.1 * sigma);
    EXPECT_TRUE(doubts_of(r).empty());
}

INSTANTIATE_TEST_SUITE_P(Errors, ToldRateTest, ::testing::Values(0.01, -0.01, 0.001, -0.001));

TEST(LagChoiceTest, SecondHarmonicAloneWidensTheError) {
    SyntheticRun run;
    run.drive.rho = 0;
    run.may_stick = true;
    run.drive.gamma = 3 * paper_g;
    const Reduction r = reduce(make_measurement(run));
    EXPECT_TRUE(say(r.notes, "the lag's error contains the others"));
    EXPECT_LT(std::abs(r.delay_s.value - run.late_s), 3 * r.delay_s.sigma);
}

TEST(LagChoiceTest, UncertaintyOfHalfAPeriodIsUnique) {
    SyntheticRun run;
    run.drive.frequency = 25;
    run.late_s = 0.0008;
    const Reduction r = reduce(make_measurement(run));
    EXPECT_TRUE(r.notes.empty()) << r.notes.front();
}

TEST(HardClockTest, FourFramesAPeriodAreRefused) {
    SyntheticRun run;
    run.frame_rate_hz = 80;
    try {
        reduce(make_measurement(run));
        FAIL() << "no error";
    } catch (const InputError& e) {
        EXPECT_NE(std::string{e.what()}.find("too few frames: 4 per drive period"), std::string::npos)
            << e.what();
    }
}

TEST(HardClockTest, PhaseLockedFramesAreRight) {
    for (const double frames : {5.0, 10.0, 50.0}) {
        SyntheticRun run;
        run.frame_rate_hz = 20 * frames;
        const Reduction r = reduce(make_measurement(run));
        EXPECT_LT(std::abs(r.v_D.value - drift_velocity(run)), 4 * r.v_D.sigma + 1e-6) << frames;
        EXPECT_LT(std::abs(r.delay_s.value - run.late_s + 20e-6), 5 * r.delay_s.sigma) << frames;
    }
}

TEST(HardClockTest, NinetyPercentLostFramesAreRight) {
    SyntheticRun run;
    run.views = 2;
    Measurement m = make_measurement(run);
    std::mt19937_64 random{11};
    for (auto* views : {&m.walkers, &m.bases}) {
        for (MotionSeries& s : *views) {
            MotionSeries kept;
            kept.view = s.view;
            for (std::size_t i = 0; i < s.t_s.size(); ++i) {
                if (random() % 10 != 0) continue;
                kept.t_s.push_back(s.t_s[i]);
                kept.x_m.push_back(s.x_m[i]);
                kept.sd_m.push_back(s.sd_m[i]);
            }
            kept.lost = static_cast<int>(s.t_s.size() - kept.t_s.size());
            s = kept;
        }
    }
    const Reduction r = reduce(m);
    EXPECT_LT(std::abs(r.v_D.value - drift_velocity(run)), 4 * r.v_D.sigma);
    EXPECT_LT(std::abs(r.delay_s.value - run.late_s + 20e-6), 4 * r.delay_s.sigma);
    EXPECT_TRUE(say(r.notes, "lost"));
}

TEST(HardClockTest, TwoPeriodsCoverTheDelay) {
    SyntheticRun run;
    run.periods = 2;
    const Reduction r = reduce(make_measurement(run));
    EXPECT_LT(std::abs(r.delay_s.value - run.late_s), 4 * r.delay_s.sigma);
    EXPECT_LT(std::abs(r.gamma.value - run.drive.gamma), 4 * r.gamma.sigma);
}

}  // namespace
}  // namespace shaker::reduction

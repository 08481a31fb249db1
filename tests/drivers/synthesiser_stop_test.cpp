#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "drivers/synthesiser.hpp"
#include "tests/support/no_alloc.hpp"
#include "tests/support/tracking/splatter.hpp"

namespace shaker {
namespace {

constexpr double rate = 48000;
constexpr double f = 20;
constexpr std::int64_t period = 2400;

std::vector<double> play(Synthesiser& synth, std::int64_t samples) {
    std::vector<double> volts(static_cast<std::size_t>(samples));
    synth.fill(volts);
    return volts;
}

double weight(std::int64_t i, std::int64_t samples) {
    return 0.5 + 0.5 * std::cos(std::numbers::pi * static_cast<double>(i) / static_cast<double>(samples));
}

/// Two synthesisers with the same commands: one is stopped, the other continues.
struct Pair {
    Synthesiser stopped{rate, f, 1}, goes_on{rate, f, 1};
    void set(const DriveCommand& c) {
        stopped.set(c);
        goes_on.set(c);
    }
    void skip(std::int64_t samples) {
        stopped.skip(samples);
        goes_on.skip(samples);
    }
};

// The angle of the weight's cosine is kept to 2^-64 turn a sample, the cosine to 2e-16.
constexpr double rounding = 1e-14;

void expect_weighted(Pair& pair, std::int64_t samples, bool ramp_goes_on = false) {
    pair.stopped.stop(samples, ramp_goes_on);
    const std::vector<double> got = play(pair.stopped, samples + 3000);
    const std::vector<double> want = play(pair.goes_on, samples + 3000);
    for (std::int64_t i = 0; i < std::ssize(got); ++i) {
        const auto k = static_cast<std::size_t>(i);
        if (i < samples)
            ASSERT_NEAR(got[k], want[k] * weight(i, samples), rounding) << i;
        else
            ASSERT_EQ(got[k], 0) << i;
    }
    EXPECT_TRUE(pair.stopped.phase() == pair.goes_on.phase()) << "the phase runs on";
}

TEST(SynthesiserStopTest, StopFallsByRaisedCosineToSilence) {
    for (const std::int64_t begin : {12000, 12001, 13333}) {
        Pair pair;
        pair.set(test::biharmonic(0.9, 1, f));
        pair.skip(begin);
        expect_weighted(pair, 2400);
    }
}

// As recordings of before have it.
TEST(SynthesiserStopTest, RampThatGoesOnIsWeighted) {
    Pair pair;
    DriveCommand c = test::biharmonic(0.9, 1, f);
    c.ramp_periods = 4;
    pair.set(c);
    pair.skip(5000);
    expect_weighted(pair, 2400, true);  // ends before the ramp would
    Pair later;
    later.set(c);
    later.skip(4 * period - 100);
    expect_weighted(later, 2400, true);  // the ramp ends on the way
}

// Wherever in a ramp the stop comes, and a second one in it, no period has a larger peak than the one before.
TEST(SynthesiserStopTest, EnvelopeNeverGrowsAfterAStop) {
    constexpr int ramp_periods = 10;
    for (std::int64_t at = 100; at < ramp_periods * period; at += 1237)
        for (const std::int64_t second : {std::int64_t{0}, 3 * period}) {
            Synthesiser synth{rate, f, 1};
            DriveCommand c = test::biharmonic(0.9, 1, f);
            c.ramp_periods = ramp_periods;
            synth.set(c);
            const std::vector<double> before = play(synth, at);
            synth.stop(ramp_periods * period);
            ASSERT_NE(synth.change(), nullptr);
            EXPECT_EQ(synth.change()->ramp, synth.change()->stop);
            std::vector<double> after = play(synth, second > 0 ? second : ramp_periods * period);
            if (second > 0) {
                synth.stop(period / 2);
                for (const double v : play(synth, period)) after.push_back(v);
            }
            EXPECT_NEAR(after.back(), 0, 1e-6);
            double last = INFINITY;
            for (std::size_t from = 0; from + period <= after.size(); from += period) {
                double peak = 0;
                for (std::size_t i = from; i < from + period; ++i) peak = std::max(peak, std::abs(after[i]));
                EXPECT_LE(peak, last) << "stop at " << at << ", period " << from / period;
                last = peak;
            }
            const double step = std::abs(after.front() - before.back());
            EXPECT_LT(step, 0.9 * 8 * two_pi * f / rate) << "no step at " << at;
        }
}

TEST(SynthesiserStopTest, StopDuringFrequencyRampKeepsPhase) {
    for (const bool ramp_goes_on : {false, true}) {
        Pair pair;
        pair.set(test::biharmonic(0.9, 1, f));
        pair.skip(2 * period);
        DriveCommand faster = test::biharmonic(0.5, 2, 31.7);
        faster.ramp_periods = 3;
        pair.set(faster);
        pair.skip(period);
        if (ramp_goes_on) {
            expect_weighted(pair, 1200, true);
        } else {
            pair.stopped.stop(1200);
            pair.skip(4200);
        }
        pair.skip(4 * period);
        EXPECT_TRUE(pair.stopped.phase() == pair.goes_on.phase()) << "also behind the end of the ramp";
    }
}

TEST(SynthesiserStopTest, StopDropsAndRefusesCommandsUntilRelease) {
    Synthesiser synth{rate, f, 1};
    synth.set(test::biharmonic(0.5, 0, f));
    play(synth, 3 * period + 10);
    synth.set(test::biharmonic(0.9, 0, f));
    synth.stop(240);
    EXPECT_FALSE(synth.release()) << "not before the stop has ended";
    synth.set(test::biharmonic(0.7, 0, f));
    EXPECT_EQ(synth.refused(), 1U);
    play(synth, 240);
    EXPECT_TRUE(synth.stopped());
    for (const double v : play(synth, 5 * period)) ASSERT_EQ(v, 0);
    synth.set(test::biharmonic(0.7, 0, f));
    EXPECT_EQ(synth.refused(), 2U);
    EXPECT_TRUE(synth.silent());
    EXPECT_TRUE(synth.release());
    EXPECT_FALSE(synth.stopped());
    for (const double v : play(synth, 2 * period)) ASSERT_EQ(v, 0) << "what was forgotten stays forgotten";
    synth.set(test::biharmonic(0.7, 0, f));
    play(synth, period);
    ASSERT_NE(synth.change(), nullptr);
    EXPECT_EQ(high_word(synth.change()->phase) >> 54, 0U) << "at a start of a period of the old phase";
}

TEST(SynthesiserStopTest, ShorterStopSteepensWithoutStep) {
    Pair pair;
    pair.set(test::biharmonic(0.9, 1, f));
    pair.skip(3 * period);
    pair.stopped.stop(2400);
    std::vector<double> got = play(pair.stopped, 1000);
    pair.stopped.stop(240);
    ASSERT_NE(pair.stopped.change(), nullptr);
    EXPECT_EQ(pair.stopped.change()->first.n, 3 * period + 1000);
    for (const double v : play(pair.stopped, 500)) got.push_back(v);
    const std::vector<double> want = play(pair.goes_on, 1500);
    // The angle of the cosine was 1000/2400 of half a turn; the rest of it takes 240 samples.
    for (std::int64_t i = 0; i < 1500; ++i) {
        const double angle = i < 1000
                                 ? static_cast<double>(i) / 2400
                                 : 1000.0 / 2400 + (1 - 1000.0 / 2400) * static_cast<double>(i - 1000) / 240;
        const double w = i < 1240 ? 0.5 + 0.5 * std::cos(std::numbers::pi * angle) : 0;
        ASSERT_NEAR(got[static_cast<std::size_t>(i)], want[static_cast<std::size_t>(i)] * w, rounding) << i;
    }
}

TEST(SynthesiserStopTest, LaterEndingStopIsIgnored) {
    Pair pair;
    pair.set(test::biharmonic(0.9, 1, f));
    pair.skip(3 * period);
    pair.stopped.stop(240);
    pair.goes_on.stop(240);
    EXPECT_EQ(play(pair.stopped, 100), play(pair.goes_on, 100));
    pair.stopped.stop(2400);
    EXPECT_EQ(pair.stopped.change(), nullptr);
    pair.stopped.stop(140);  // ends at the same sample
    EXPECT_EQ(pair.stopped.change(), nullptr);
    EXPECT_EQ(play(pair.stopped, 1000), play(pair.goes_on, 1000));
    pair.stopped.stop(1);
    EXPECT_EQ(pair.stopped.change(), nullptr) << "it is silent already";
}

TEST(SynthesiserStopTest, SteadyDriveStopsWithSlopeOfWeight) {
    Synthesiser synth{rate, f, 1};
    synth.set(test::biharmonic(1, 0.3, f));
    synth.skip(3 * period);
    synth.stop(2400);
    double last = play(synth, 1).back();
    double largest = 0;
    for (const double v : play(synth, 3000)) {
        largest = std::max(largest, std::abs(v - last));
        last = v;
    }
    // The signal's own slope is at most (1/2 + 2/2) w / rate, the weight's at most pi / (2 x 2400).
    EXPECT_LE(largest, 1.5 * two_pi * f / rate + std::numbers::pi / 4800);
}

// A cut is at -26 dB, a hard stop of 5 ms at -65.
TEST(SynthesiserStopTest, OnePeriodStopSpreadsLikeLiveChange) {
    for (std::int64_t phase = 0; phase < period; phase += 400) {
        Synthesiser synth{rate, f, 1};
        synth.set(test::biharmonic(1, 0.3, f));
        synth.skip(3 * period + phase);
        std::vector<double> signal = play(synth, 33600);
        synth.stop(2400);
        for (const double v : play(synth, 33600)) signal.push_back(v);
        EXPECT_LT(test::splatter_db(signal, rate, 500), -100) << phase;
    }
}

TEST(SynthesiserStopTest, BlockSizesDoNotMatter) {
    const auto played = [](auto next_size) {
        Synthesiser synth{rate, f, 2};
        synth.set(test::biharmonic(1, 0.3, 31.7));
        std::vector<double> got;
        const auto until = [&](std::int64_t end) {
            while (std::ssize(got) < end)
                for (const double v : play(synth, std::min(next_size(), end - std::ssize(got))))
                    got.push_back(v);
        };
        until(4001);
        synth.stop(2400);
        until(5003);
        synth.stop(333);
        until(9000);
        return got;
    };
    std::int64_t n = 0;
    EXPECT_EQ(played([] { return std::int64_t{100000}; }), played([&] { return n++ % 97 + 1; }));
}

// The recorded changes reproduce every sample, including stops and releases.
TEST(SynthesiserStopTest, ReplayingTheChangesGivesIdenticalSamples) {
    std::mt19937_64 random{7};
    std::uniform_real_distribution<double> unit{0, 1};
    Synthesiser live{rate, f, 3};
    std::vector<DriveChange> changes;
    std::vector<double> want;
    int stops = 0;
    for (int i = 0; i < 2000; ++i) {
        if (i % 7 == 0) live.set(test::biharmonic(unit(random), 6 * unit(random), 10 + 50 * unit(random)));
        if (i % 100 == 40 || (i % 100 == 42 && unit(random) < 0.5)) {
            live.stop(static_cast<std::int64_t>(100 + 3000 * unit(random)));
            if (live.change() != nullptr) {
                EXPECT_GT(live.change()->stop, 0);
                changes.push_back(*live.change());
                ++stops;
            }
        }
        if (i % 100 == 60) {
            EXPECT_TRUE(live.release());
        }
        for (const double v : play(live, 256)) want.push_back(v);
        if (live.change() != nullptr) changes.push_back(*live.change());
    }
    ASSERT_GE(stops, 22);

    Synthesiser again{rate, f, 3};
    std::vector<double> got;
    for (const DriveChange& change : changes) {
        for (const double v : play(again, change.first.n - again.tick().n)) got.push_back(v);
        ASSERT_TRUE(again.phase() == change.phase);
        if (change.stop > 0) {
            again.stop(change.stop, change.ramp == 0);
        } else {
            ASSERT_TRUE(again.release());
            again.set(change.command);
        }
    }
    for (const double v : play(again, std::ssize(want) - std::ssize(got))) got.push_back(v);
    EXPECT_EQ(got, want);
}

TEST(SynthesiserStopTest, SkippingMatchesFilling) {
    Pair pair;
    pair.set(test::biharmonic(0.9, 1, f));
    pair.skip(3 * period);
    pair.stopped.stop(2400);
    pair.goes_on.stop(2400);
    play(pair.stopped, 700);
    pair.goes_on.skip(700);
    EXPECT_EQ(play(pair.stopped, 3000), play(pair.goes_on, 3000));
}

TEST(SynthesiserStopTest, UnderrunDuringStopStaysStopped) {
    Synthesiser synth{rate, f, 1};
    synth.set(test::biharmonic(0.9, 1, f));
    synth.skip(3 * period);
    synth.stop(2400);
    play(synth, 240);
    synth.silence(100);
    for (const double v : play(synth, 5000)) ASSERT_EQ(v, 0);
    EXPECT_TRUE(synth.stopped());
    EXPECT_TRUE(synth.release());
}

TEST(SynthesiserStopTest, DoesNotAllocate) {
    Synthesiser synth{rate, f, 1};
    synth.set(test::biharmonic(0.9, 1, f));
    synth.skip(3 * period);
    std::array<double, 240> block;
    const test::NoAlloc guard;
    synth.stop(2400);
    for (int i = 0; i < 5; ++i) synth.fill(block);
    synth.stop(240);
    for (int i = 0; i < 5; ++i) synth.fill(block);
    EXPECT_TRUE(synth.release());
}

TEST(SynthesiserStopTest, RefusedSoftStopIsNotReported) {
    Synthesiser synth{rate, f, 1};
    synth.set(test::biharmonic(0.9, 1, f));
    play(synth, 3 * period);
    synth.stop(240);
    ASSERT_NE(synth.change(), nullptr);
    synth.set({.volts = {}, .stop_s = 0.1});
    EXPECT_EQ(synth.change(), nullptr) << "the trip's stop was reported already";
}

TEST(SynthesiserStopTest, GoingBackRepeatsEverySample) {
    Synthesiser synth{rate, f, 0.5};
    synth.set(test::biharmonic(0.9, 1, f));
    play(synth, 3 * period);
    const Synthesiser before = synth;
    synth.set(test::biharmonic(0.4, 2, 1.5 * f));
    const std::vector<double> first = play(synth, 5000);
    const std::uint64_t clamped = synth.clamped();
    EXPECT_GT(clamped, 0U);
    Synthesiser earlier = before;
    earlier.set(test::biharmonic(0.4, 2, 1.5 * f));
    std::vector<double> again(1234);
    synth.go_back(earlier, again);
    EXPECT_EQ(synth.clamped(), clamped) << "counters do not go back";
    for (const double v : play(synth, 5000 - 1234)) again.push_back(v);
    EXPECT_EQ(again, first);
    synth.limit(0.1);
    synth.go_back(before, {});
    synth.stop(240);
    play(synth, 480);
    EXPECT_TRUE(synth.release());
    synth.set(test::biharmonic(0.9, 1, f));
    for (const double v : play(synth, 5000)) ASSERT_LE(std::abs(v), 0.1) << "the newest limit holds";
}

// First samples 10, 20, 30; then a stop at 15 that took back 30, and one command more.
TEST(SynthesiserStopTest, ChangesAfterAStopThatTookBackAreVoid) {
    const auto change = [](std::int64_t first, std::int64_t ramp, std::int64_t taken_back = 0) {
        DriveChange c{.command = {}, .first = {first}, .ramp = ramp};
        c.taken_back = taken_back;
        c.stop = taken_back > 0 ? 4 : 0;
        return c;
    };
    const std::vector<DriveChange> all{change(10, 2), change(20, 2), change(30, 2), change(15, 0, 30),
                                       change(40, 2)};
    std::vector<std::int64_t> firsts;
    for (const DriveChange& c : in_effect(all)) firsts.push_back(c.first.n);
    EXPECT_EQ(firsts, (std::vector<std::int64_t>{10, 15, 40}));
    EXPECT_EQ(in_force_at(all, 5), 0U);
    EXPECT_EQ(in_force_at(all, 12), 0U);
    EXPECT_EQ(in_force_at(all, 18), 0U) << "the stop is not complete";
    EXPECT_EQ(in_force_at(all, 19), 3U);
    EXPECT_EQ(in_force_at(all, 35), 3U) << "the change at 30 never took effect";
    EXPECT_EQ(in_force_at(all, 42), 4U);
    EXPECT_EQ(in_force_at({}, 42), 0U);
}

}  // namespace
}  // namespace shaker

#include "daemon/safety/predicted_motion.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace shaker::safety {
namespace {

constexpr double dac_rate = 48000, rate = 4000;

Expectation expectation(double frequency, double gain = 1) {
    Expectation e{
        .frequency = frequency, .at = {100}, .dac_sample = 1200, .dac_per_tick = 12, .settling_s = 0};
    e.response.fill(gain);
    return e;
}

DriveCommand command(double volts, double frequency, int ramp_periods = 1) {
    DriveCommand c{.volts = {}, .frequency = frequency, .ramp_periods = ramp_periods};
    c.volts.at(1) = volts;
    c.volts.at(2) = std::polar(0.5 * volts, 1.0);
    return c;
}

// With a response of 1 the prediction equals the synthesiser's output. In a ramp of the frequency the
// synthesiser's phase is a sum and the predicted one an integral: they differ by half a sample of the change,
// 1e-4 of a turn here.
TEST(PredictedMotionTest, UnitResponsePredictsThePlayedDrive) {
    Synthesiser synth{dac_rate, 20, 10};
    PredictedMotion motion{rate, 20, dac_rate};
    motion.expect(expectation(20));
    std::mt19937_64 rng{2};
    std::uniform_real_distribution<double> unit{0, 1};
    double worst = 0;
    std::vector<double> volts(240);
    for (int i = 0; i < 20000; ++i) {
        if (i % 200 == 0) {
            const double f = i % 400 == 0 ? 20 : 20 + 10 * unit(rng);
            motion.expect(expectation(f));
            synth.set(command(unit(rng), f, 1 + static_cast<int>(4 * unit(rng))));
        }
        const std::int64_t n = synth.tick().n;
        synth.fill(volts);
        if (synth.change() != nullptr) motion.hear(*synth.change());
        for (std::int64_t k = 0; k < 240; k += 12) {
            const auto p = motion.at({(n + k) / 12});
            ASSERT_TRUE(p);
            worst = std::max(worst, std::abs(p->value - volts[static_cast<std::size_t>(k)]));
        }
    }
    EXPECT_LT(worst, 2e-3);
}

TEST(PredictedMotionTest, PredictsSoftStopsAlsoDuringRamps) {
    Synthesiser synth{dac_rate, 20, 10};
    PredictedMotion motion{rate, 20, dac_rate};
    motion.expect(expectation(20));
    std::mt19937_64 rng{3};
    std::uniform_real_distribution<double> unit{0, 1};
    double worst = 0, largest = 0;
    std::vector<double> volts(240);
    const auto hear = [&] {
        if (synth.change() != nullptr) motion.hear(*synth.change());
    };
    const auto play = [&](int blocks) {
        for (; blocks > 0; --blocks) {
            const std::int64_t n = synth.tick().n;
            synth.fill(volts);
            hear();
            for (std::int64_t k = 0; k < 240; k += 12) {
                const auto p = motion.at({(n + k) / 12});
                ASSERT_TRUE(p);
                worst = std::max(worst, std::abs(p->value - volts[static_cast<std::size_t>(k)]));
                largest = std::max(largest, std::abs(p->value));
            }
        }
    };
    for (int i = 0; i < 100; ++i) {
        synth.set(command(0.5 + unit(rng), 20, 1 + static_cast<int>(10 * unit(rng))));
        play(static_cast<int>(100 * unit(rng)));
        synth.set({.volts = {}, .sequence = 1, .stop_s = 0.02 + 0.5 * unit(rng)});
        hear();
        play(200);
        ASSERT_TRUE(synth.silent());
    }
    EXPECT_LT(worst, 1e-9);
    EXPECT_GT(largest, 1);
}

TEST(PredictedMotionTest, AppliesAnnouncedChangeAtItsSample) {
    Synthesiser synth{dac_rate, 20, 10};
    PredictedMotion motion{rate, 20, dac_rate};
    motion.expect(expectation(20, 3));
    synth.set(command(1, 20));
    synth.skip(1);
    motion.hear(*synth.change());
    synth.skip(4799);
    synth.set(command(0.2, 20));
    synth.skip(10);
    ASSERT_NE(synth.change(), nullptr);
    EXPECT_EQ(synth.change()->first.n, 4800);
    motion.hear(*synth.change());
    EXPECT_EQ(motion.at({0})->rms, 0);
    EXPECT_NEAR(motion.at({399})->rms, 3 * std::sqrt(0.5 * 1.25), 1e-12);
    EXPECT_NEAR(motion.at({600})->rms, 0.6 * std::sqrt(0.5 * 1.25), 1e-12);
}

TEST(PredictedMotionTest, IsEmptyWithoutMapOrResponseOrAfterStop) {
    Synthesiser synth{dac_rate, 20, 10};
    PredictedMotion motion{rate, 20, dac_rate};
    synth.set(command(1, 20));
    synth.skip(240);
    motion.hear(*synth.change());
    EXPECT_FALSE(motion.at({10}));
    motion.expect(expectation(25));
    EXPECT_FALSE(motion.at({11})) << "a response of another frequency";
    motion.expect(expectation(20));
    EXPECT_TRUE(motion.at({12}));
    synth.stop(2400);
    motion.hear(*synth.change());
    EXPECT_TRUE(motion.at({19}));
    EXPECT_FALSE(motion.at({20})) << "from its first sample on";
    synth.skip(4800);
    ASSERT_TRUE(synth.release());
    synth.set(command(1, 20));
    synth.skip(4800);
    motion.hear(*synth.change());
    EXPECT_TRUE(motion.at({1000})) << "until the change after it";
    synth.silence(1000);
    motion.hear(*synth.change());
    EXPECT_FALSE(motion.at({2000})) << "the map is not to be trusted when the DAC ran empty";
}

TEST(PredictedMotionTest, SlackBoundsTransientAfterChange) {
    PredictedMotion motion{rate, 20, dac_rate};
    Expectation e = expectation(20);
    e.settling_s = 0.02;
    motion.expect(e);
    Synthesiser synth{dac_rate, 20, 10};
    synth.set(command(1, 20));
    synth.skip(1);
    motion.hear(*synth.change());
    const double change = std::sqrt(0.5 * 1.25);
    EXPECT_NEAR(motion.at({100})->slack, 1.5 * change, 1e-12) << "in the ramp of 50 ms";
    EXPECT_NEAR(motion.at({200 + 80})->slack, 1.5 * change * std::exp(-1), 1e-9) << "20 ms behind it";
    EXPECT_LT(motion.at({200 + 4000})->slack, 1e-9);
}

TEST(PredictedMotionTest, ChangesThatWereTakenBackAreNotPredicted) {
    Synthesiser synth{dac_rate, 20, 10};
    PredictedMotion motion{rate, 20, dac_rate};
    motion.expect(expectation(20));
    std::vector<double> volts(4800);
    synth.set(command(0.5, 20));
    synth.fill(std::span{volts}.first(4700));
    motion.hear(*synth.change());
    const Synthesiser before = synth;
    synth.set(command(1, 20));
    synth.fill(volts);
    ASSERT_EQ(synth.change()->first.n, 4800);
    motion.hear(*synth.change());
    ASSERT_TRUE(motion.at({4692 / 12}));
    synth.go_back(before, std::span{volts}.first(0));
    synth.stop(240);
    DriveChange stop = *synth.change();
    stop.taken_back = 4800;
    motion.hear(stop);
    EXPECT_FALSE(motion.at({4716 / 12})) << "stopped";
    EXPECT_FALSE(motion.at({9600 / 12})) << "the second command was never played";
}

}  // namespace
}  // namespace shaker::safety

#include "drivers/synthesiser.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "drivers/errors.hpp"
#include "tests/support/no_alloc.hpp"

namespace shaker {
namespace {

constexpr double rate = 48000;
constexpr double f = 20;
constexpr std::int64_t period = 2400;

DriveCommand command(double gamma, double phi, double frequency = f, int ramp_periods = 1) {
    DriveCommand c;
    c.volts.at(1) = 0.5 * gamma;
    c.volts.at(2) = std::polar(0.5 * gamma, phi);
    c.frequency = frequency;
    c.ramp_periods = ramp_periods;
    return c;
}

/// All harmonics, of equal amplitude, that sum up to full scale.
DriveCommand all_harmonics(double frequency) {
    DriveCommand c{.volts = {}, .frequency = frequency};
    for (int q = 1; q <= max_harmonics; ++q) c.volts.at(q) = std::polar(1.0 / max_harmonics, 0.7 * q);
    return c;
}

std::vector<double> play(Synthesiser& synth, std::int64_t samples) {
    std::vector<double> volts(static_cast<std::size_t>(samples));
    synth.fill(volts);
    return volts;
}

/// The signal at a phase of numerator / denominator turns, from the C library in long double.
double exact(const Harmonics<Voltage>& h, std::int64_t numerator, std::int64_t denominator) {
    long double sum = 0;
    for (int q = 1; q <= max_harmonics; ++q) {
        const auto turns = static_cast<long double>((q * numerator) % denominator) / denominator;
        const long double angle = 2 * std::numbers::pi_v<long double> * turns;
        sum += h.at(q).real() * std::sin(angle) + h.at(q).imag() * std::cos(angle);
    }
    return static_cast<double>(sum);
}

TEST(SynthesiserTest, StartsSilentAtPhaseZero) {
    Synthesiser synth{rate, f, 1};
    for (const double v : play(synth, 5000)) EXPECT_EQ(v, 0);
    EXPECT_EQ(synth.tick().n, 5000);
    EXPECT_EQ(synth.change(), nullptr);
}

TEST(SynthesiserTest, SamplesAreExactToRounding) {
    constexpr double exact_f = 23.4375;  // 2048 samples a period: a step without rounding
    Synthesiser synth{rate, exact_f, 10};
    const DriveCommand all = all_harmonics(exact_f);
    synth.set(all);
    play(synth, 2048);
    std::int64_t n = 2048;
    // Horner's rule amplifies the roundings of sine and cosine by up to the harmonic number: 16 x 2e-16 of
    // the sum.
    for (const double v : play(synth, 5000)) EXPECT_NEAR(v, exact(all.volts, n++, 2048), 3.2e-15);
}

struct Jump {
    double frequency;  // a multiple of 1/32 Hz, so that the reference is an exact ratio
    std::int64_t samples;
};
class LongRun : public testing::TestWithParam<Jump> {};

// The phase that is read is cut to 2^-64 turn and converted to a double, 1.1e-16 of an eighth of a turn,
// which a harmonic q makes q times larger; the rest is what Horner's rule adds. Nothing of it grows with
// time.
TEST_P(LongRun, HarmonicsStayExactAfterABillionSamples) {
    const auto [frequency, samples] = GetParam();
    Synthesiser synth{rate, frequency, 1};
    const DriveCommand c = all_harmonics(frequency);
    synth.set(c);
    synth.skip(samples);
    ASSERT_EQ(synth.tick().n, samples);
    const auto numerator = static_cast<std::int64_t>(frequency * 32);
    const std::int64_t denominator = static_cast<std::int64_t>(rate) * 32;
    std::int64_t n = samples;
    double worst = 0;
    for (const double v : play(synth, 5000)) {
        worst = std::max(worst, std::abs(v - exact(c.volts, n++ % denominator * numerator, denominator)));
    }
    EXPECT_LE(worst, 3.2e-15);
}
INSTANTIATE_TEST_SUITE_P(Frequencies, LongRun,
                         testing::Values(Jump{20, 1'000'000'000}, Jump{25, 1'000'000'000},
                                         Jump{23.4375, 1'000'000'000}, Jump{37.03125, 999'999'937},
                                         Jump{0.125, 1'000'000'000}, Jump{500, 1'000'000'001}));

TEST(SynthesiserTest, SkippingMatchesFilling) {
    Synthesiser filled{rate, f, 2};
    Synthesiser skipped{rate, f, 2};
    for (Synthesiser* s : {&filled, &skipped}) {
        s->set(command(1, 0.3));
        play(*s, 3000);
        s->set(command(0.7, 1, 31.4));
    }
    for (const std::int64_t n : {1, 1799, 7, 600, 2000, 100003}) {
        play(filled, n);
        skipped.skip(n);
        EXPECT_TRUE(filled.phase() == skipped.phase());
        EXPECT_EQ(filled.tick(), skipped.tick());
        EXPECT_EQ(filled.change() == nullptr, skipped.change() == nullptr);
    }
    EXPECT_EQ(play(filled, 5000), play(skipped, 5000));
}

TEST(SynthesiserTest, CommandTakesEffectWherePhaseWraps) {
    Synthesiser synth{rate, 23.4375, 1};  // 2048 samples a period, exactly
    play(synth, 100);
    DriveCommand c = command(0.5, 0);
    c.sequence = 42;
    synth.set(c);
    play(synth, 1000);
    EXPECT_EQ(synth.change(), nullptr);
    play(synth, 1000);
    ASSERT_NE(synth.change(), nullptr);
    EXPECT_EQ(synth.change()->first.n, 2048);
    EXPECT_TRUE(synth.change()->phase == 0);
    EXPECT_EQ(synth.change()->ramp, 2048);
    EXPECT_EQ(synth.change()->command.sequence, 42U);
    play(synth, 1000);
    EXPECT_EQ(synth.change(), nullptr) << "a change is reported only in the block in which it began";
}

TEST(SynthesiserTest, FractionalPeriodStartsWithinOneSample) {
    Synthesiser synth{rate, 37.03, 1};
    for (int i = 0; i < 50; ++i) {
        synth.set(command(0.1 + 0.01 * i, 0, 37.03));
        play(synth, 3000);  // more than a ramp and a period
        ASSERT_NE(synth.change(), nullptr);
        EXPECT_TRUE(synth.change()->phase < synth.change()->step);
    }
}

struct Start {
    std::int64_t numerator, denominator;  // frequency, Hz: a double without rounding
};
class PeriodStart : public testing::TestWithParam<Start> {};

// 25 Hz has 1920 samples a period, of which a step has no exact share; 37.03125 Hz has no whole number.
TEST_P(PeriodStart, PeriodStartsAtFirstSampleAtOrAfterItsTime) {
    const auto [numerator, denominator] = GetParam();
    const double frequency = static_cast<double>(numerator) / static_cast<double>(denominator);
    const std::int64_t turn = static_cast<std::int64_t>(rate) * denominator;
    Synthesiser synth{rate, frequency, 1};
    for (const std::int64_t far : {0, 1'000, 1'000'000'007, 2'000'000'000}) {
        synth.skip(std::max<std::int64_t>(0, far - synth.tick().n));
        for (int i = 0; i < 20; ++i) {
            synth.skip(1 + 13 * i);
            const std::int64_t asked = synth.tick().n;
            synth.set(command(0.01 * i, 0, frequency));
            synth.skip(turn / numerator + 2);
            ASSERT_NE(synth.change(), nullptr);
            const std::int64_t k = (asked - 1) * numerator / turn + 1;  // periods that began before
            EXPECT_EQ(synth.change()->first.n, (k * turn + numerator - 1) / numerator)
                << "asked at " << asked;
            synth.skip(turn / numerator + 2);  // the ramp ends
        }
    }
}
INSTANTIATE_TEST_SUITE_P(Frequencies, PeriodStart,
                         testing::Values(Start{20, 1}, Start{25, 1}, Start{31, 1}, Start{375, 16},
                                         Start{1185, 32}, Start{1, 8}, Start{500, 1}, Start{7, 1},
                                         Start{11111, 1}));

TEST(SynthesiserTest, BlockSizesDoNotMatter) {
    Synthesiser whole{rate, f, 2};
    Synthesiser parts{rate, f, 2};
    for (Synthesiser* s : {&whole, &parts}) s->set(command(1, 0.3, 31.7));
    const std::vector<double> want = play(whole, 20000);
    std::vector<double> got;
    for (std::int64_t n = 1; got.size() < want.size(); n = n % 97 + 1)
        for (const double v : play(parts, std::min<std::int64_t>(n, 20000 - std::ssize(got))))
            got.push_back(v);
    EXPECT_EQ(got, want);
}

// The recorded changes reproduce every sample, computed here by the definition in long double.
TEST(SynthesiserTest, ChangesDetermineEverySampleOfRamps) {
    Synthesiser synth{rate, f, 3};
    std::vector<DriveChange> changes;
    std::vector<double> volts;
    for (const DriveCommand& c : {command(1, 0.3), command(1.5, 2, 31.7, 2), command(0.2, -3, 11.1, 3)}) {
        synth.set(c);
        const auto block = play(synth, 12000);
        volts.insert(volts.end(), block.begin(), block.end());
        ASSERT_NE(synth.change(), nullptr);
        changes.push_back(*synth.change());
    }
    for (std::size_t k = 0; k < changes.size(); ++k) {
        const DriveChange& change = changes[k];
        const Harmonics<Voltage> from = k > 0 ? changes[k - 1].command.volts : Harmonics<Voltage>{};
        const Turns step = k > 0 ? changes[k - 1].step : turns_per_sample(f, rate);
        const std::int64_t end = k + 1 < changes.size() ? changes[k + 1].first.n : std::ssize(volts);
        std::uint64_t phase = high_word(change.phase);
        for (std::int64_t n = change.first.n; n < end; ++n) {
            const auto i = std::min(n - change.first.n, change.ramp);
            const long double weight =
                0.5L - 0.5L * std::cos(std::numbers::pi_v<long double> * i / change.ramp);
            const long double angle = 2 * std::numbers::pi_v<long double> * (phase * 0x1p-64L);
            long double want = 0;
            for (int q = 1; q <= 2; ++q) {
                const auto a = from.at(q), b = change.command.volts.at(q);
                want += (a.real() + weight * (b.real() - a.real())) * std::sin(q * angle) +
                        (a.imag() + weight * (b.imag() - a.imag())) * std::cos(q * angle);
            }
            // Steps on the way are rounded from doubles, to 1e-16 of the change in step: 1e-12 rad in all.
            ASSERT_NEAR(volts[static_cast<std::size_t>(n)], static_cast<double>(want), 1e-12)
                << "sample " << n;
            const auto difference =
                static_cast<long double>(high_word(change.step)) - static_cast<long double>(high_word(step));
            phase +=
                high_word(step) + static_cast<std::uint64_t>(static_cast<std::int64_t>(weight * difference));
        }
        if (k + 1 < changes.size()) {
            const auto off = static_cast<std::int64_t>(phase - high_word(changes[k + 1].phase));
            EXPECT_LT(std::abs(static_cast<double>(off)) * 0x1p-64, 1e-13);
        }
    }
}

TEST(SynthesiserTest, ReplayingTheChangesGivesIdenticalSamples) {
    std::mt19937_64 random{7};
    std::uniform_real_distribution<double> unit{0, 1};
    Synthesiser live{rate, f, 3};
    std::vector<DriveChange> changes;
    std::vector<double> want;
    for (int i = 0; i < 400; ++i) {
        if (i % 7 == 0) live.set(command(unit(random), 6 * unit(random), 10 + 50 * unit(random), 1 + i % 3));
        const auto block = play(live, 256);
        want.insert(want.end(), block.begin(), block.end());
        if (live.change()) changes.push_back(*live.change());
    }
    ASSERT_GE(changes.size(), 10U);

    Synthesiser again{rate, f, 3};
    std::vector<double> got;
    for (const DriveChange& change : changes) {
        const auto before = play(again, change.first.n - again.tick().n);
        got.insert(got.end(), before.begin(), before.end());
        ASSERT_TRUE(again.phase() == change.phase);
        again.set(change.command);
    }
    const auto rest = play(again, std::ssize(want) - std::ssize(got));
    got.insert(got.end(), rest.begin(), rest.end());
    EXPECT_EQ(got, want);
}

TEST(SynthesiserTest, NewestCommandWaitsForEndOfRamp) {
    Synthesiser synth{rate, f, 1};
    synth.set(command(0.5, 0, f, 2));
    play(synth, 1000);
    synth.set(command(0.1, 0));
    play(synth, 1000);
    const DriveCommand newest = command(0.9, 0.4);
    synth.set(newest);
    play(synth, 2 * period - 2000);
    EXPECT_EQ(synth.change(), nullptr) << "the first ramp is not over yet";
    play(synth, period + 1);
    ASSERT_NE(synth.change(), nullptr);
    EXPECT_EQ(synth.change()->first.n, 2 * period);
    EXPECT_EQ(synth.change()->command.volts, newest.volts);
    play(synth, period);
    EXPECT_EQ(synth.change(), nullptr) << "the command that was replaced must not come later";
}

TEST(SynthesiserTest, ASoftStopEndsInExactSilence) {
    Synthesiser synth{rate, f, 1};
    synth.set(command(0.9, 1, f, 10));
    play(synth, 12 * period);
    DriveCommand stop;
    stop.ramp_periods = 10;
    synth.set(stop);
    play(synth, 10 * period + 10);
    for (const double v : play(synth, 1000)) EXPECT_EQ(v, 0);
}

TEST(SynthesiserTest, SamplesBeyondTheLimitAreCutAndCounted) {
    Synthesiser synth{rate, f, 0.3};
    synth.set(command(1, 0));
    play(synth, period);
    const std::uint64_t before = synth.clamped();
    std::uint64_t at_limit = 0;
    for (const double v : play(synth, period)) {
        EXPECT_LE(std::abs(v), 0.3);
        at_limit += std::abs(v) == 0.3;
    }
    EXPECT_GT(at_limit, 100U);
    EXPECT_EQ(synth.clamped() - before, at_limit);
}

TEST(SynthesiserTest, RefusesAndCountsUnplayableCommands) {
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    constexpr double infinity = std::numeric_limits<double>::infinity();
    constexpr double huge = std::numeric_limits<double>::max();
    Synthesiser synth{rate, f, 1};
    const DriveCommand good = command(0.5, 0.1);
    synth.set(good);
    std::vector<DriveCommand> bad(11, good);
    bad[0].volts.at(1) = nan;
    bad[1].volts.at(16) = {0, infinity};
    bad[2].volts.at(3) = {-infinity, nan};
    bad[3].volts.at(1) = bad[3].volts.at(2) = huge;
    bad[4].frequency = nan;
    bad[5].frequency = infinity;
    bad[6].frequency = 0;
    bad[7].frequency = -20;
    bad[8].frequency = 12000;  // its second harmonic is half the rate
    bad[9].frequency = 1e-9;
    bad[10].ramp_periods = 0;
    for (const DriveCommand& c : bad) synth.set(c);
    EXPECT_EQ(synth.refused(), bad.size());
    play(synth, 1);
    ASSERT_NE(synth.change(), nullptr) << "a refused command must not replace a good one";
    EXPECT_EQ(synth.change()->command.volts, good.volts);
}

TEST(SynthesiserTest, RandomChangesNeverJumpNorLeaveOffset) {
    std::mt19937_64 random{11};
    std::uniform_real_distribution<double> unit{0, 1};
    Synthesiser synth{rate, f, 1};
    double last = 0;
    double sum = 0;
    double largest_step = 0;
    std::array<double, 256> block;
    for (int i = 0; i < 1000; ++i) {
        const double rho = unit(random);
        DriveCommand c = command(0, 0);
        c.volts.at(1) = std::polar(rho, two_pi * unit(random));
        c.volts.at(2) = std::polar(1 - rho, two_pi * unit(random));
        synth.set(c);
        for (int k = 0; k < 20; ++k) {
            synth.fill(block);
            for (const double v : block) {
                largest_step = std::max(largest_step, std::abs(v - last));
                sum += v;
                last = v;
            }
        }
    }
    EXPECT_EQ(synth.clamped(), 0U);
    // Steady, the slope is at most that of a full second harmonic, 2 w / rate = 5.2e-3; ramps add a tenth.
    EXPECT_LE(largest_step, 1.1 * 2 * two_pi * f / rate);
    // The direct part of a ramp, 4/(3 pi) of a period at most for a change by 1, is linear in the change: the
    // sum of all telescopes to that of one change by at most 1.
    // A ramp's direct part is linear in the change, 2/(3 pi) of a period for 1 V: over all changes it
    // telescopes to that of one by at most 1 V. The last period, which is cut off, adds at most 1/pi.
    EXPECT_LE(std::abs(sum), (2.0 / 3 + 1) / std::numbers::pi * period);
}

TEST(SynthesiserTest, RealisesEveryPlayableFrequencyToTheLastBit) {
    std::mt19937_64 random{3};
    std::uniform_real_distribution<double> exponent{-4, 4};
    for (int i = 0; i < 1000; ++i) {
        const double asked = std::pow(10, exponent(random));
        EXPECT_EQ(Synthesiser::realised(asked, rate), asked);
        EXPECT_EQ(Synthesiser::realised(asked, 44100.1), asked);
    }
}

TEST(SynthesiserTest, RefusesInvalidArguments) {
    EXPECT_THROW((Synthesiser{0, f, 1}), InputError);
    EXPECT_THROW((Synthesiser{rate, 24000, 1}), InputError);
    EXPECT_THROW((Synthesiser{rate, -1, 1}), InputError);
    EXPECT_THROW((Synthesiser{rate, f, 0}), InputError);
    EXPECT_THROW((Synthesiser{rate, f, std::numeric_limits<double>::quiet_NaN()}), InputError);
}

TEST(SynthesiserTest, DoesNotAllocate) {
    Synthesiser synth{rate, f, 1};
    const DriveCommand c = command(0.5, 1, 31);
    std::array<double, 256> block;
    const test::NoAlloc guard;
    synth.fill(block);
    synth.set(c);
    for (int i = 0; i < 40; ++i) synth.fill(block);
    synth.skip(100000);
}

}  // namespace
}  // namespace shaker

#include "tests/support/splatter.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "drivers/synthesiser.hpp"

namespace shaker {
namespace {

constexpr double rate = 48000;
constexpr std::int64_t half = 1 << 15;  // samples on either side of the middle of the change

DriveCommand biharmonic(double gamma, double phi, double frequency) {
    DriveCommand c;
    c.volts.at(1) = 0.5 * gamma;
    c.volts.at(2) = std::polar(0.5 * gamma, phi);
    c.frequency = frequency;
    return c;
}

/// 1.4 s around a change from gamma 0.6, phi 0 at 20 Hz to something else; the ramp is one period in its
/// middle.
std::vector<double> around_change_to(const DriveCommand& to) {
    Synthesiser synth{rate, 20, 2};
    synth.set(biharmonic(0.6, 0, 20));
    std::vector<double> volts(2 * half);
    synth.skip(100 * 2400 + 1200 - half);
    synth.fill(std::span{volts}.first(half - 1200));
    synth.set(to);
    synth.fill(std::span{volts}.last(half + 1200));
    EXPECT_TRUE(synth.change() != nullptr && synth.change()->first.n == 100 * 2400);
    return volts;
}

TEST(SplatterTest, TheMeasureSeesAJumpAtThePeriodBoundary) {
    Synthesiser before{rate, 20, 2};
    Synthesiser after{rate, 20, 2};
    before.set(biharmonic(0.6, 0, 20));
    after.set(biharmonic(1, two_pi / 4, 20));
    before.skip(240000);
    after.skip(240000 + half);
    std::vector<double> volts(2 * half);
    before.fill(std::span{volts}.first(half));
    after.fill(std::span{volts}.last(half));
    const double dB = test::splatter_dB(volts, rate, 500);
    EXPECT_GT(dB, -50);  // a jump by half of full scale: -34 dB within its own second
    EXPECT_LT(dB, -20);
}

TEST(SplatterTest, TheMeasuresOwnFloorIsFarBelowTheGoal) {
    Synthesiser synth{rate, 20, 2};
    synth.set(biharmonic(1, 0.4, 20));
    synth.skip(10000);
    std::vector<double> volts(2 * half);
    synth.fill(volts);
    EXPECT_LT(test::splatter_dB(volts, rate, 500), -200);
}

TEST(SplatterTest, ALiveChangeOfGammaAndPhiStaysBelowMinus100dBAbove500Hz) {
    EXPECT_LT(test::splatter_dB(around_change_to(biharmonic(1, two_pi / 4, 20)), rate, 500), -100);
}

TEST(SplatterTest, ALiveChangeOfFrequencyToo) {
    EXPECT_LT(test::splatter_dB(around_change_to(biharmonic(0.6, 0, 25)), rate, 500), -100);
    EXPECT_LT(test::splatter_dB(around_change_to(biharmonic(1, two_pi / 4, 31.7)), rate, 500), -100);
}

}  // namespace
}  // namespace shaker

#include "tests/support/tracking/splatter.hpp"

#include <gtest/gtest.h>

namespace shaker::test {
namespace {

constexpr double rate = 48000;
constexpr double above = 500;
const DriveCommand before = biharmonic(0.6, 0, 20);
const DriveCommand after = biharmonic(1, two_pi / 4, 20);

TEST(SplatterTest, MeasureDetectsJumpAtStartOfPeriod) {
    // A jump by half of full scale: about -34 dB where the ramp has to stay below -100.
    const double dB = splatter_db(around_jump(before, after), rate, above);
    EXPECT_GT(dB, -45);
    EXPECT_LT(dB, -25);
}

TEST(SplatterTest, TheMeasuresOwnFloorIsFarBelowTheGoal) {
    EXPECT_LT(splatter_db(around_ramp(before, before), rate, above), -200);
}

TEST(SplatterTest, LiveChangeStaysBelowMinus100dBAbove500Hz) {
    EXPECT_LT(splatter_db(around_ramp(before, after), rate, above), -100);
}

TEST(SplatterTest, LiveFrequencyChangeStaysBelowMinus100dB) {
    EXPECT_LT(splatter_db(around_ramp(before, biharmonic(0.6, 0, 25)), rate, above), -100);
    EXPECT_LT(splatter_db(around_ramp(before, biharmonic(1, two_pi / 4, 31.7)), rate, above), -100);
}

}  // namespace
}  // namespace shaker::test


#include <gtest/gtest.h>

#include <cmath>

#include "daemon/report/results.hpp"

namespace shaker::report {
namespace {

TEST(SpeedDifferenceTest, HasAShareOfTheExpectedValue) {
    EXPECT_EQ(speed_difference({0.0145, 3e-6}, 0.0144, 3), "+100.000 um/s = +0.694 %");
    EXPECT_EQ(speed_difference({-0.0145, 3e-6}, -0.0144, 3), "-100.000 um/s = -0.694 %");
}

TEST(SpeedDifferenceTest, HasNoShareOfZeroOrOfLessThanItsError) {
    for (const double expected : {0.0, 1.7e-17, -2.9e-6, 3e-6})
        EXPECT_EQ(speed_difference({1e-4 + expected, 3e-6}, expected, 3), "+100.000 um/s") << expected;
    EXPECT_EQ(speed_difference({1e-4, NAN}, 1e-17, 3), "+100.000 um/s");
}

TEST(NoStickTextTest, ReportsShortestDetectableStick) {
    EXPECT_EQ(no_stick_text(0.0312), "never for over 0.031 T");
    EXPECT_EQ(no_stick_text(1), "not known: too few frames, or slips too short");
    EXPECT_EQ(no_stick_text(NAN), "never");
}

}  // namespace
}  // namespace shaker::report

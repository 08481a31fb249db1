// The error determines the digits of a value, at each power of ten, too.
#include "drivers/with_error.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace shaker {
namespace {

TEST(WithErrorTest, TheErrorHasTwoDigitsAfterRounding) {
    EXPECT_EQ(with_error(14.5823, 0.0987), "14.582 +- 0.099");
    EXPECT_EQ(with_error(14.5823, 0.0996), "14.58 +- 0.10");
    EXPECT_EQ(with_error(14.5823, 0.1), "14.58 +- 0.10");
    EXPECT_EQ(with_error(-14.5823, 9.96), "-15 +- 10");
    EXPECT_EQ(with_error(1234.5, 345), "1234 +- 345");
    EXPECT_EQ(with_error(1e-9, 1e-15), "0.000000001000 +- 0.000000000000") << "at most 12 decimals";
}

TEST(WithErrorTest, AnUnknownErrorOrValueIsNotShown) {
    EXPECT_EQ(with_error(0.12345678, NAN), "0.123457");
    EXPECT_EQ(with_error(0.12345678, 0), "0.123457");
    EXPECT_EQ(with_error(0.12345678, INFINITY), "0.123457");
    EXPECT_EQ(with_error(NAN, 0.1), "-");
}

}  // namespace
}  // namespace shaker

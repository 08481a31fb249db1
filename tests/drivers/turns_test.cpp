#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "drivers/synthesiser.hpp"

namespace shaker {
namespace {

TEST(TurnsTest, WordsAreTheUpperAndTheLowerHalf) {
    const Turns t = turns_of(0x0123456789abcdef, 0xfedcba9876543210);
    EXPECT_EQ(high_word(t), 0x0123456789abcdefU);
    EXPECT_EQ(low_word(t), 0xfedcba9876543210U);
}

TEST(TurnsTest, ARatioThatIsAPowerOfTwoIsExact) {
    EXPECT_TRUE(turns_per_sample(1, 4) == turns_of(std::uint64_t{1} << 62, 0));
    EXPECT_TRUE(turns_per_sample(0x1p-100, 1) == turns_of(0, std::uint64_t{1} << 28));
    EXPECT_TRUE(turns_per_sample(0, 48000) == 0);
}

// 48000 steps of a whole number f of Hz are f turns, plus less than 48000 units because a step is rounded up.
TEST(TurnsTest, SecondOfStepsGainsLessThanOneUnitPerStep) {
    for (std::uint64_t f = 1; f < 24000; f += 7) {
        const Turns ahead = Turns{48000} * turns_per_sample(static_cast<double>(f), 48000);
        EXPECT_TRUE(ahead < 48000) << f << " Hz";
    }
}

// Random doubles: steps times the rate less the frequency, in whole numbers of the last place of the rate.
TEST(TurnsTest, IsTheExactRatioRoundedUpForAnyDoubles) {
    std::mt19937_64 random{5};
    constexpr std::uint64_t mantissa = std::uint64_t{1} << 53;
    for (int i = 0; i < 1000; ++i) {
        const std::uint64_t rate = mantissa / 2 + random() % (mantissa / 2);
        const std::uint64_t frequency = random() % (rate / 2);
        // step rate = frequency 2^128 + r with 0 <= r < rate, so the product is r, modulo 2^128.
        const Turns step = turns_per_sample(static_cast<double>(frequency), static_cast<double>(rate));
        EXPECT_TRUE(step * rate < rate);
        EXPECT_NEAR(static_cast<double>(step) * 0x1p-128 * static_cast<double>(rate),
                    static_cast<double>(frequency), 1e-15 * static_cast<double>(rate));
    }
}

TEST(TurnsTest, TheLargestAndTheSmallestRatesDivideToo) {
    for (const double scale : {0x1p-1000, 0x1p1000})
        EXPECT_TRUE(turns_per_sample(25 * scale, 48000 * scale) == turns_per_sample(25, 48000));
}

}  // namespace
}  // namespace shaker

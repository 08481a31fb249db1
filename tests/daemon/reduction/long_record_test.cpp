// Minutes of an experiment without pictures, compared with the exact motion.
#include <gtest/gtest.h>

#include <cmath>

#include "daemon/reduction/reduction.hpp"
#include "tests/support/recording/long_run.hpp"

namespace shaker::reduction {
namespace {

Reduction reduced(const test::LongStreams& run) {
    return reduce(measurement_of(run.streams, run.header.frequency_hz, run.from_s, run.to_s));
}

TEST(LongRecordTest, TwoHundredSecondsGiveDriftWithinErrors) {
    constexpr int runs = 3;
    double squares = 0;
    for (std::uint64_t seed = 1; seed <= runs; ++seed) {
        const test::LongStreams run = test::make_long_streams({.seconds = 200, .seed = seed});
        const Reduction r = reduced(run);
        const double off = (r.v_D.value - run.v_D) / r.v_D.sigma;
        EXPECT_LT(std::abs(off), 4) << "seed " << seed;
        squares += off * off;
        // 2 um in 400 000 positions over 200 s: white noise alone leaves 2 um sqrt(12 / 400 000) / 200 s.
        // Possible scatter of the drift itself increases sigma by a factor of up to about 5.
        EXPECT_LT(r.v_D.sigma, 6 * 2e-6 * std::sqrt(12.0 / 4e5) / 200);
        EXPECT_EQ(r.frames + r.frames_lost, 400'000);
        EXPECT_GT(r.frames_lost, 0);
        ASSERT_EQ(r.stick.size(), 1U);  // near the phase without drift each period has a rest
    }
    EXPECT_GT(squares / runs, 0.01);  // far too large errors would hide any bias
}

TEST(LongRecordTest, FastDriftIsFoundToo) {
    const test::LongStreams run =
        test::make_long_streams({.seconds = 200, .drive = {.frequency = 20, .gamma = 2 * paper_g, .phi = 0}});
    const Reduction r = reduced(run);
    EXPECT_NEAR(1e3 * run.v_D, 36.5359, 1e-4);  // mm/s, by the closed form, which is exact here
    EXPECT_LT(std::abs(r.v_D.value - run.v_D), 4 * r.v_D.sigma);
    EXPECT_TRUE(r.stick.empty());
}

}  // namespace
}  // namespace shaker::reduction

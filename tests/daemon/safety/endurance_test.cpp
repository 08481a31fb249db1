// Normal operation with set-point changes never trips. In virtual time.
#include "tests/support/safety/endurance.hpp"

#include <gtest/gtest.h>

#include <cstdio>

#include "tests/support/nightly.hpp"

namespace shaker::test {
namespace {

TEST(EnduranceTest, HourOfSetPointsOnSoundBenchesDoesNotTrip) {
    Endurance all;
    const double enough_s = SHAKER_SANITIZED ? 600 : 3600.0 * plays(1, 1);  // SHAKER_COUNT: hours
    for (std::uint64_t seed = seed_of_day(1); all.simulated_s < enough_s; ++seed) all += endure(seed, 300);
    for (const std::string& trip : all.trips) ADD_FAILURE() << trip;
    std::printf("%.2f h, %ld set-points, %.2f h at their target\n", all.simulated_s / 3600, all.set_points,
                all.locked_s / 3600);
    EXPECT_GT(all.set_points, enough_s / 18);
    EXPECT_GT(all.locked_s, 0.3 * all.simulated_s);
}

// A change of target faster than the prediction, two changes in quick succession, a walker put on the base
// directly after a change.
TEST(EnduranceTest, SeedsThatOnceTrippedDoNotTrip) {
    std::vector<std::uint64_t> seeds{1221, 229, 1201, 1138, 1135, 1152, 1192, 1219, 1237};
    if (SHAKER_SANITIZED) seeds.resize(1);
    Endurance all;
    for (const std::uint64_t seed : seeds) all += endure(seed, 600);
    for (const std::string& trip : all.trips) ADD_FAILURE() << trip;
    EXPECT_EQ(all.runs, static_cast<int>(seeds.size()));
}

}  // namespace
}  // namespace shaker::test

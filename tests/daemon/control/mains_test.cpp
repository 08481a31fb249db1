// The mains in a sensor at rest are found, and nothing else is taken for them.
#include "daemon/control/mains.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "tests/support/nightly.hpp"

namespace shaker::control {
namespace {

struct Rest {
    double rate_hz = 4000, seconds = 0.65, noise = 0.02;
    double hz = 50, hum = 0;  // m/s^2, on x
    double second = 0;        // the same, at twice the frequency
    double settling = 0;      // m/s^2, of a constant part that decays within a second
    std::array<double, 3> rest{0.1, 9.7, 0.4};
};

std::optional<Mains> heard(const Rest& r, unsigned seed) {
    std::mt19937_64 random{seed};
    std::normal_distribution<double> noise{0, r.noise};
    MainsWatch watch{r.rate_hz};
    const double from_s = 17.03 + 1e-3 * seed;
    for (int i = 0; i < r.seconds * r.rate_hz; ++i) {
        const double t = from_s + i / r.rate_hz, turn = 2 * std::numbers::pi * r.hz * t;
        const double slow = r.settling * std::exp(-(t - from_s));
        watch.add(t,
                  {r.rest[0] + r.hum * std::sin(turn) + r.second * std::cos(2 * turn) + slow + noise(random),
                   r.rest[1] + noise(random), r.rest[2] + noise(random)});
    }
    return watch.found();
}

TEST(MainsWatchTest, FindsHumWithItsFrequencyAndAmplitude) {
    for (const double hz : {49.95, 50.03, 59.97, 60.05})
        for (unsigned seed = 0; seed < 20; ++seed) {
            const auto mains = heard({.hz = hz, .hum = 0.05, .second = 0.03}, seed);
            ASSERT_TRUE(mains) << hz;
            EXPECT_NEAR(mains->hz, hz, 0.1);
            EXPECT_NEAR(mains->amplitude[0], 0.05, 0.005);
            EXPECT_NEAR(mains->amplitude[1], 0.03, 0.005);
            EXPECT_EQ(mains->amplitude[2], 0);
        }
}

TEST(MainsWatchTest, TakesNothingElseForTheMains) {
    const unsigned seeds = static_cast<unsigned>(test::plays(100, 10000));
    const std::pair<const char*, Rest> cases[] = {{"noise", {}},
                                                  {"a sensor that settles", {.noise = 1e-4, .settling = 0.5}},
                                                  {"a pump", {.hz = 48.4, .hum = 0.05}}};
    for (const auto& [name, rest] : cases)
        for (unsigned seed = 0; seed < seeds; ++seed) {
            ASSERT_FALSE(heard(rest, seed)) << name;
            Rest humming = rest;
            humming.hz = 50, humming.hum = 0.05;
            ASSERT_TRUE(heard(humming, seed)) << name << ", with hum";
        }
    EXPECT_FALSE(heard({.rate_hz = 100, .hum = 0.05}, 1)) << "a slow sensor";
    EXPECT_FALSE(heard({.seconds = 0.3, .hum = 1}, 1)) << "too short";
}

TEST(MainsWatchTest, HarmonicsOnALineAreHidden) {
    EXPECT_EQ(hidden_harmonics({50.03}, 25, 8), std::vector<int>{2});
    EXPECT_EQ(hidden_harmonics({50.03, 100.06}, 20, 8), std::vector<int>{5});
    EXPECT_TRUE(hidden_harmonics({50.03}, 20, 8).empty());
    EXPECT_TRUE(hidden_harmonics({50.03}, 5, 8).empty()) << "beyond the last harmonic";
    EXPECT_TRUE(hidden_harmonics({}, 25, 8).empty());
}

}  // namespace
}  // namespace shaker::control

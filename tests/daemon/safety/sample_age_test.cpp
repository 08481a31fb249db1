// Age of the newest checked accelerometer sample: the output guard trips when it grows, whatever its driver
// knows about time, and not when clocks drift.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <optional>

#include "daemon/safety/output_guard.hpp"

namespace shaker::safety {
namespace {

constexpr double rate = 48000, told_rate = 4000;
constexpr std::int64_t block = 240;
constexpr double missing_s = 0.03;
constexpr double most_s = missing_s + OutputGuard::held_back_s;  // growth of the age that trips
constexpr double normal_delay_s = 0.004;

HostTime host(double s) { return HostTime{std::chrono::nanoseconds{std::llround(1e9 * (500 + s))}}; }

Limits limits() {
    Limits l;
    l.missing_s = missing_s;
    return l;
}

/// A drive and a sensor whose samples arrive behind a delay, in blocks of 64.
struct LateSensor {
    bool stamps = true;            // else AccelBlock::arrived is the arrival
    double true_rate = told_rate;  // Hz
    std::function<double(double)> delay = [](double) { return normal_delay_s; };  // at a time, s

    OutputGuard guard{rate, told_rate, limits()};
    OutputSigns signs{.silent = false};
    Warnings warnings{};

    [[nodiscard]] double now_s() const { return static_cast<double>(signs.tick) / rate; }
    /// Plays until a time or the first trip.
    std::optional<Trip> until(double s) {
        while (now_s() < s) {
            signs.played = {{signs.tick}, host(now_s()), 0, 0};
            signs.tick += block;
            signs.gathered = signs.tick;
            const std::int64_t size = AccelBlock::capacity;
            const double arrived_until_s = now_s() - delay(now_s());
            const auto to = static_cast<std::int64_t>(arrived_until_s * true_rate) / size * size;
            if (to > signs.checked_to.n) {
                ++signs.judged;
                signs.checked_to = {to};
                signs.checked_arrived = host(stamps ? static_cast<double>(to) / true_rate : now_s());
            }
            if (const auto trip = guard.check(signs, warnings)) return trip;
        }
        return {};
    }
};

std::function<double(double)> growing(double share, double from_s) {
    return [=](double s) { return normal_delay_s + share * std::max(0.0, s - from_s); };
}

// Clocks that drift by 1e-3 without stamps and by 1e-4 with them are no growth; the rest is. Quantities in
// blocks of 16 ms, so the least age is known to that.
TEST(SampleAgeTest, AnyGrowthTripsInTime) {
    for (const bool stamps : {true, false})
        for (const double share : {0.9, 0.5, 0.12, 0.01, 0.002, 0.0005}) {
            const double allowed = stamps ? 1e-4 : 1e-3;
            if (share <= allowed) continue;
            LateSensor sensor{.stamps = stamps, .delay = growing(share, 20)};
            ASSERT_FALSE(sensor.until(20));
            const auto trip = sensor.until(5000);
            ASSERT_TRUE(trip) << share;
            EXPECT_EQ(trip->cause, Cause::sensor_missing);
            EXPECT_EQ(trip->stop, StopKind::soft);
            const double grown_s = share * (sensor.now_s() - 20);
            EXPECT_LT(grown_s * (1 - allowed / share), most_s + 0.016) << share;
            if (share > 0.3) continue;  // blocks that come too seldom are a silence
            EXPECT_GT(grown_s, most_s - 0.016) << share;
            EXPECT_NEAR(trip->value, most_s, 0.01);
            EXPECT_EQ(trip->limit, most_s);
        }
}

TEST(SampleAgeTest, WrongRateDoesNotTripWithinHours) {
    for (const bool stamps : {true, false})
        for (const double error : {-0.05, -1e-3, 1e-3, 0.05}) {
            LateSensor sensor{.stamps = stamps, .true_rate = told_rate * (1 + error)};
            const auto trip = sensor.until(3 * 3600);
            EXPECT_FALSE(trip) << error << " " << sensor.now_s() << " s: " << text(*trip);
        }
}

// The sensor warms up: its rate changes by 500 ppm within ten minutes.
TEST(SampleAgeTest, RateThatDriftsDoesNotTrip) {
    LateSensor sensor{.stamps = false, .delay = [](double s) {
                          const double warm_s = std::min(s, 600.0);
                          return normal_delay_s + 500e-6 * (0.5 * warm_s * warm_s / 600 + s - warm_s);
                      }};
    const auto trip = sensor.until(3600);
    EXPECT_FALSE(trip) << text(*trip);
}

TEST(SampleAgeTest, RateThatIsWrongHidesNoGrowth) {
    LateSensor sensor{.stamps = false, .true_rate = 0.95 * told_rate, .delay = growing(0.12, 20)};
    ASSERT_FALSE(sensor.until(20));
    ASSERT_TRUE(sensor.until(60));
    EXPECT_LT(0.12 * (sensor.now_s() - 20), most_s + 0.016);
}

// The output stood still: its newest PlayTime is old and the samples are new.
TEST(SampleAgeTest, MomentOfShorterDelayIsNotTheLeast) {
    DelayGrowth age{0, 1e-4};
    double now_s = 0, growth_s = 0;
    const auto last = [&](double delay_s, double for_s) {
        for (const double end_s = now_s + for_s; now_s < end_s; now_s += 0.005)
            growth_s = age.add(now_s, delay_s);
    };
    last(0.2, 10);
    last(0, 0.05);
    last(0.2, 0.005);
    EXPECT_LT(growth_s, 0.011);
    last(0, 10);
    last(0.2, 0.005);
    EXPECT_GT(growth_s, 0.19) << "shorter for seconds";
}

// The time of the samples goes on while the DAC is empty, and so do its ticks.
TEST(SampleAgeTest, UnderrunIsNotAGrowth) {
    Limits without = limits();
    without.detectors.reset(static_cast<std::size_t>(Cause::underrun));
    LateSensor sensor;
    sensor.guard.hold_to(without);
    for (int i = 1; i < 20; ++i) {
        EXPECT_FALSE(sensor.until(3 * i));
        sensor.signs.tick += 12000;
    }
}

// A start is refused while the bench is tripped, so nothing is driven on samples that are old.
TEST(SampleAgeTest, LateSensorTripsAtRest) {
    LateSensor sensor{.delay = growing(0.12, 20)};
    sensor.signs.silent = true;
    ASSERT_FALSE(sensor.until(20));
    ASSERT_TRUE(sensor.until(50));
    EXPECT_NEAR(sensor.now_s(), 20 + most_s / 0.12, 0.15);
    sensor.guard.rearm();  // the operator clears it
    const double cleared_s = sensor.now_s();
    EXPECT_TRUE(sensor.until(50)) << "the delay is still there";
    EXPECT_NEAR(sensor.now_s(), cleared_s, 0.021);
}

TEST(SampleAgeTest, DelayThatIsGoneIsAccepted) {
    LateSensor sensor{.delay = [](double s) {
        return normal_delay_s +
               (s < 20 ? 0 : std::max(0.0, 0.12 * (std::min(s, 24.0) - 20) - (s > 30 ? 1 : 0)));
    }};
    ASSERT_TRUE(sensor.until(30));
    ASSERT_FALSE(sensor.until(31)) << "reported";
    sensor.guard.rearm();
    EXPECT_FALSE(sensor.until(100)) << "the samples have caught up";
}

TEST(SampleAgeTest, SensorWithoutLimitsIsCountedOnly) {
    LateSensor sensor{.delay = growing(0.12, 20), .guard{rate, told_rate, std::nullopt}};
    EXPECT_FALSE(sensor.until(30));
    EXPECT_GT(sensor.warnings[Cause::sensor_missing], 0U);
}

}  // namespace
}  // namespace shaker::safety

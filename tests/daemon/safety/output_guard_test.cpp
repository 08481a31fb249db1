#include "daemon/safety/output_guard.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/no_alloc.hpp"

namespace shaker::safety {
namespace {

constexpr double rate = 48000;
constexpr std::int64_t block = 240;

/// Blocks of 5 ms with signs of life, which a test can switch off.
struct Life {
    explicit Life(const std::optional<Limits>& limits, double accelerometer_rate_hz = 4000)
        : guard{rate, accelerometer_rate_hz, limits} {}
    /// Time until the first trip, s; empty without a trip in this time.
    std::optional<double> trips_within(double s) {
        const std::int64_t from = signs.tick;
        while (static_cast<double>(signs.tick - from) < s * rate) {
            signs.tick += block;
            if (sensor && signs.tick / 768 != (signs.tick - block) / 768) ++signs.judged;
            if (reduction) signs.gathered = signs.tick - block;
            if ((trip = guard.check(signs, warnings))) return static_cast<double>(signs.tick - from) / rate;
        }
        return {};
    }
    OutputGuard guard;
    OutputSigns signs{.silent = false, .peak_V = 0.5};
    Warnings warnings;
    std::optional<Trip> trip;
    bool sensor = true, reduction = true;
};

Limits limits() {
    Limits l;
    l.drive = {0.8, 1};
    return l;
}

Limits without(Cause cause) {
    Limits l = limits();
    l.detectors.reset(static_cast<std::size_t>(cause));
    return l;
}

TEST(OutputGuardTest, DoesNotTripOnWorkingBench) {
    Life life{limits()};
    EXPECT_FALSE(life.trips_within(10000)) << text(*life.trip);
}

// The accelerometer's blocks are 16 ms long, 20 ms without a block are allowed, and the output checks every 5
// ms.
TEST(OutputGuardTest, SilentAccelerometerTripsInPlayedTime) {
    Life life{limits()};
    ASSERT_FALSE(life.trips_within(1.6));  // a block has just come
    life.sensor = false;
    const auto after = life.trips_within(1);
    ASSERT_TRUE(after);
    EXPECT_GT(*after, 0.0199);
    EXPECT_LE(*after, 0.0251);
    EXPECT_EQ(life.trip->cause, Cause::sensor_missing);
    EXPECT_EQ(life.trip->stop, StopKind::soft);
    EXPECT_TRUE(life.trip->on_dac_clock);
    EXPECT_EQ(life.trip->tick, life.signs.tick);

    Life off{without(Cause::sensor_missing)};
    off.trips_within(1);
    off.sensor = false;
    EXPECT_FALSE(off.trips_within(2));
    Life none{limits(), 0};
    none.sensor = false;
    EXPECT_FALSE(none.trips_within(2)) << "a bench without accelerometer";
}

TEST(OutputGuardTest, WaitsForFirstBlockUntilDriveIsOn) {
    Life idle{limits()};
    idle.sensor = false;
    idle.signs.silent = true;
    EXPECT_FALSE(idle.trips_within(10));
    idle.signs.silent = false;
    EXPECT_TRUE(idle.trips_within(0.03));
    Life lost{limits()};
    lost.signs.silent = true;
    lost.trips_within(1);
    lost.sensor = false;
    EXPECT_TRUE(lost.trips_within(0.03)) << "also without a drive";
}

TEST(OutputGuardTest, WaitsForLongBlocks) {
    Life slow{limits(), 1000};  // 64 ms a block
    EXPECT_FALSE(slow.trips_within(10));
    slow.sensor = false;
    const auto after = slow.trips_within(1);
    ASSERT_TRUE(after);
    EXPECT_NEAR(*after, 1.25 * 0.064, 0.0151);
}

TEST(OutputGuardTest, StalledReductionTripsWhileDriveIsOn) {
    Life life{limits()};
    life.trips_within(1);
    life.reduction = false;
    life.signs.silent = true;
    EXPECT_FALSE(life.trips_within(10));
    life.signs.silent = false;
    const auto after = life.trips_within(10);
    ASSERT_TRUE(after);
    EXPECT_NEAR(*after, limits().watchdog_s, 0.0051);
    EXPECT_EQ(life.trip->cause, Cause::watchdog);
    Life off{without(Cause::watchdog)};
    off.trips_within(1);
    off.reduction = false;
    EXPECT_FALSE(off.trips_within(10));
}

TEST(OutputGuardTest, CutSampleTripsWithRequestedVolts) {
    for (const bool on : {true, false}) {
        Life life{on ? limits() : without(Cause::drive)};
        life.trips_within(1);
        life.signs.clamped = 3;
        life.signs.largest_clamped_V = 1.25;
        life.signs.peak_V = 1;
        EXPECT_EQ(life.trips_within(0.005).has_value(), on);
        if (!on) continue;
        EXPECT_EQ(life.trip->cause, Cause::drive);
        EXPECT_EQ(life.trip->stop, StopKind::hard);
        EXPECT_EQ(life.trip->value, 1.25);
        EXPECT_EQ(life.trip->limit, 1);
    }
}

TEST(OutputGuardTest, UnderrunTrips) {
    for (const bool on : {true, false}) {
        Life life{on ? limits() : without(Cause::underrun)};
        life.trips_within(1);
        life.signs.played.lost = 480;
        EXPECT_EQ(life.trips_within(0.005).has_value(), on);
        EXPECT_EQ(life.warnings[Cause::underrun], on ? 0U : 1U);
        if (on) {
            EXPECT_EQ(life.trip->cause, Cause::underrun);
        }
    }
}

TEST(OutputGuardTest, ReportsEachCauseOnceUntilRearmed) {
    Life life{limits()};
    life.trips_within(1);
    life.sensor = false;
    ASSERT_TRUE(life.trips_within(1));
    EXPECT_FALSE(life.trips_within(1));
    life.guard.rearm();
    EXPECT_TRUE(life.trips_within(0.005));
}

TEST(OutputGuardTest, CountsBlocksAboveWarningLevel) {
    Life life{limits()};
    life.signs.peak_V = 0.9;
    life.trips_within(1);
    EXPECT_EQ(life.warnings[Cause::drive], 200U);
}

TEST(OutputGuardTest, WithoutLimitsItCountsAndNeverTrips) {
    Life life{std::nullopt};
    life.sensor = life.reduction = false;
    life.signs.clamped = 5;
    life.signs.played.lost = 7;
    EXPECT_FALSE(life.trips_within(10));
    for (const Cause c : {Cause::sensor_missing, Cause::watchdog, Cause::drive, Cause::underrun})
        EXPECT_GT(life.warnings[c], 0U) << name(c);
    EXPECT_EQ(life.guard.stop_samples(StopKind::soft), 2400) << "for the operator's stop";
}

TEST(OutputGuardTest, DoesNotAllocate) {
    Life life{limits()};
    const test::NoAlloc guard;
    life.trips_within(1);
    life.sensor = false;
    life.trips_within(1);
}

Limits with_coil() {
    Limits l = limits();
    l.coil_A = {1.6, 2};
    l.coil_A_per_V = 5;
    l.coil_time_s = 120;
    return l;
}

// Twice the limit's current reaches the limit's heat after 120 s ln(4/3).
TEST(OutputGuardTest, CoilHeatTripsAfterHalfAMinute) {
    Life life{with_coil()};
    life.signs.mean_square_V2 = 0.8 * 0.8;
    const auto after = life.trips_within(600);
    ASSERT_TRUE(after);
    EXPECT_NEAR(*after, 120 * std::log(4.0 / 3), 0.02);
    EXPECT_EQ(life.trip->cause, Cause::coil_heat);
    EXPECT_EQ(life.trip->stop, StopKind::soft);
    EXPECT_NEAR(life.trip->value, 2, 1e-3);
    EXPECT_GT(life.warnings[Cause::coil_heat], 0U) << "at 80 %";
}

TEST(OutputGuardTest, CoilMayCarryItsCurrentForHours) {
    Life life{with_coil()};
    life.signs.mean_square_V2 = 0.399 * 0.399;
    EXPECT_FALSE(life.trips_within(7200)) << text(*life.trip);
}

TEST(OutputGuardTest, CoilCoolsBetweenDrives) {
    Life life{with_coil()};
    for (int drive = 0; drive < 20; ++drive) {  // 20 s at twice the current, then four minutes of rest
        life.signs.mean_square_V2 = 0.8 * 0.8;
        EXPECT_FALSE(life.trips_within(20)) << drive;
        life.signs.mean_square_V2 = 0;
        EXPECT_FALSE(life.trips_within(240)) << drive;
    }
    life.signs.mean_square_V2 = 0.8 * 0.8;
    EXPECT_FALSE(life.trips_within(20));
    EXPECT_TRUE(life.trips_within(20)) << "without the rest";
}

// A clear does not cool the coil.
TEST(OutputGuardTest, HotCoilTripsSoonAfterAClear) {
    Life life{with_coil()};
    life.signs.mean_square_V2 = 0.8 * 0.8;
    ASSERT_TRUE(life.trips_within(600));
    life.signs.mean_square_V2 = 0;
    EXPECT_FALSE(life.trips_within(1));
    life.guard.rearm();
    EXPECT_FALSE(life.trips_within(1));
    life.signs.mean_square_V2 = 0.8 * 0.8;
    const auto again = life.trips_within(600);
    ASSERT_TRUE(again);
    EXPECT_LT(*again, 2);
}

TEST(OutputGuardTest, UnknownCoilIsNotChecked) {
    Limits l = with_coil();
    l.coil_A_per_V = 0;
    Life life{l};
    life.signs.mean_square_V2 = 1;
    EXPECT_FALSE(life.trips_within(600));
}

}  // namespace
}  // namespace shaker::safety

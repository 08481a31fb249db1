#include "daemon/safety/sample_guard.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "tests/support/no_alloc.hpp"
#include "tests/support/safety/guard_bench.hpp"

namespace shaker::safety {
namespace {

constexpr double rate = 4000;
constexpr double dac_rate = 48000;
constexpr double lsb = 1e-3;  // m/s^2

/// Feeds samples given by a test: motion along the axis on x, motion across it on y, gravity on z.
class Feed {
public:
    explicit Feed(const std::optional<Limits>& limits, std::array<double, 3> axis = {1, 0, 0})
        : guard{{.name = "sensor", .rate_hz = rate, .mps2_per_count = {lsb, lsb, lsb}, .shaker_axis = axis},
                dac_rate,
                limits} {
        for (int i = 0; i < 4000; ++i) add(0);  // gravity is known, integrals have settled
    }
    /// Feeds the next sample. A trip must have the tick of its sample.
    void add(double along, double across = 0) {
        AccelBlock block{.first = {next++}, .arrived = {}, .size = 1};
        ++dither;  // sensors always have noise
        block.counts[0] = {static_cast<std::int32_t>(std::lround(along / lsb)) + dither % 2,
                           static_cast<std::int32_t>(std::lround(across / lsb)), 9800 + dither % 3};
        check(block);
    }
    void check(const AccelBlock& block) {
        guard.check(block, ring, warnings);
        while (const auto t = ring.pop()) trips.push_back(*t);
    }
    /// Number of samples until the first trip; along: acceleration by sample number.
    std::optional<int> trips_after(int most, const std::function<double(int)>& along, double across = 0) {
        for (int i = 0; i < most; ++i) {
            add(along(i), across * along(i));
            if (!trips.empty()) return i;
        }
        return {};
    }
    SampleGuard guard;
    Ring<Trip> ring{8};
    Warnings warnings;
    std::vector<Trip> trips;
    std::int64_t next = 0;
    int dither = 0;
};

Limits no_levels() { return {.transverse = {INFINITY, INFINITY}}; }

Limits without(Limits limits, Cause cause) {
    limits.detectors.reset(static_cast<std::size_t>(cause));
    return limits;
}

double sine(double amplitude, double f, int i) { return amplitude * std::sin(two_pi * f * i / rate); }

TEST(SampleGuardTest, FirstSampleAboveAccelerationLimitTripsHard) {
    Limits limits = no_levels();
    limits.acceleration = {20, 30};
    Feed feed{limits};
    // The slow mean follows the signal by less than 0.1 % of it in 10 ms.
    EXPECT_FALSE(feed.trips_after(40, [](int i) { return i % 2 == 0 ? 29.9 : -29.9; }));
    EXPECT_GT(feed.warnings[Cause::acceleration], 35U);
    feed.add(-30.2);
    ASSERT_EQ(feed.trips.size(), 1U);
    EXPECT_EQ(feed.trips[0].cause, Cause::acceleration);
    EXPECT_EQ(feed.trips[0].stop, StopKind::hard);
    EXPECT_NEAR(feed.trips[0].value, 30.2, 0.1);
    EXPECT_EQ(feed.trips[0].limit, 30);
    EXPECT_EQ(feed.trips[0].tick, feed.next - 1);
    EXPECT_FALSE(feed.trips[0].on_dac_clock);

    Feed off{without(limits, Cause::acceleration)};
    EXPECT_FALSE(off.trips_after(200, [](int) { return 40; }));
}

// 10 m/s^2 at 20 Hz is 79.6 mm/s and 0.633 mm; the leak makes each integral 0.3 % short. Where the ramp ends,
// the base is truly 3 % of the amplitude off its middle for a moment.
TEST(SampleGuardTest, VelocityAndDisplacementMatchTheMotion) {
    const auto motion = [](int i) { return std::min(1.0, i / 2000.0) * sine(10, 20, i); };
    const double v = 10 / (two_pi * 20), x = v / (two_pi * 20);
    for (const double share : {1.05, 0.95}) {
        Limits limits = no_levels();
        limits.velocity = {INFINITY, share * v};
        Feed by_velocity{limits};
        EXPECT_EQ(by_velocity.trips_after(8000, motion).has_value(), share < 1) << share;
        Feed no_velocity{without(limits, Cause::velocity)};
        EXPECT_FALSE(no_velocity.trips_after(8000, motion));
        limits = no_levels();
        limits.displacement = {INFINITY, share * x};
        Feed by_displacement{limits};
        const auto tripped = by_displacement.trips_after(8000, motion);
        EXPECT_EQ(tripped.has_value(), share < 1) << share;
        if (tripped) {
            EXPECT_GT(*tripped, 1900) << "not before the ramp has nearly ended";
        }
        Feed off{without(limits, Cause::displacement)};
        EXPECT_FALSE(off.trips_after(8000, motion));
    }
}

TEST(SampleGuardTest, IntegralsForgetStepOfOffset) {
    Limits limits = no_levels();
    limits.displacement = {INFINITY, 1e-3};
    Feed feed{limits};
    // 20 mm/s^2 twice over 0.1 s are 0.2 mm, then the mean follows.
    EXPECT_FALSE(feed.trips_after(40000, [](int) { return 0.02; }));
}

TEST(SampleGuardTest, ComparesTransverseMotionWithPeakAlongAxis) {
    Limits limits{.transverse = {0.2, 0.3}};
    Feed quiet{limits};
    EXPECT_FALSE(quiet.trips_after(
        4000, [](int i) { return sine(10, 20, i); }, 0.28));
    EXPECT_GT(quiet.warnings[Cause::transverse], 0U);
    Feed feed{limits};
    EXPECT_TRUE(feed.trips_after(
        4000, [](int i) { return sine(10, 20, i); }, 0.4));
    EXPECT_EQ(feed.trips.at(0).cause, Cause::transverse);
    EXPECT_EQ(feed.trips.at(0).stop, StopKind::soft);
    Feed off{without(limits, Cause::transverse)};
    EXPECT_FALSE(off.trips_after(
        4000, [](int i) { return sine(10, 20, i); }, 0.4));
    Feed still{limits};
    EXPECT_FALSE(still.trips_after(
        4000, [](int i) { return sine(0.5, 20, i); }, 2))
        << "too little to tell";
}

TEST(SampleGuardTest, SeventhSampleAtEndOfRangeTrips) {
    Limits limits = no_levels();
    limits.sensor_range_mps2 = 20;
    Feed feed{limits};
    EXPECT_FALSE(feed.trips_after(60, [](int i) { return i % 7 == 6 ? 0.0 : 20.0; }));
    EXPECT_EQ(feed.warnings[Cause::sensor_saturated], 52U);
    feed.add(0);
    EXPECT_EQ(feed.trips_after(60, [](int) { return -20; }), 6);
    EXPECT_EQ(feed.trips.at(0).cause, Cause::sensor_saturated);
    Feed off{without(limits, Cause::sensor_saturated)};
    EXPECT_FALSE(off.trips_after(60, [](int) { return -20; }));
}

TEST(SampleGuardTest, ClippedBlockShowsUnknownRange) {
    Feed feed{no_levels()};
    AccelBlock block{.first = {feed.next}, .arrived = {}, .quality = Quality::clipped};
    for (int i = 0; i < block.size; ++i)
        block.counts[static_cast<std::size_t>(i)] = {i < 30 ? i : 524287, -i, 9800};
    block.size = 36;
    feed.check(block);
    EXPECT_TRUE(feed.trips.empty());
    block.first.n += 36;
    block.size = 64;
    feed.check(block);
    ASSERT_EQ(feed.trips.size(), 1U);
    EXPECT_EQ(feed.trips[0].cause, Cause::sensor_saturated);
    EXPECT_EQ(feed.trips[0].tick, block.first.n + 36);
}

TEST(SampleGuardTest, CountsMissingSamplesAndTripsForTooMany) {
    const Limits limits = no_levels();
    Feed feed{limits};
    feed.next += 80;  // 20 ms: allowed
    feed.add(0);
    EXPECT_TRUE(feed.trips.empty());
    EXPECT_EQ(feed.warnings[Cause::sensor_missing], 80U);
    feed.next += 81;
    feed.add(0);
    ASSERT_EQ(feed.trips.size(), 1U);
    EXPECT_EQ(feed.trips[0].cause, Cause::sensor_missing);
    EXPECT_NEAR(feed.trips[0].value, 0.02025, 1e-9);
    Feed off{without(limits, Cause::sensor_missing)};
    off.next += 1000;
    off.add(0);
    EXPECT_TRUE(off.trips.empty());
    Feed back{limits};
    back.next -= 1000;
    back.add(0);
    EXPECT_EQ(back.trips.size(), 1U) << "an index that jumps back";
}

TEST(SampleGuardTest, ChecksIntegralsAfterGapOnlyWhenSettled) {
    Limits limits = no_levels();
    limits.displacement = {INFINITY, 1e-3};  // of 0.63 mm
    Feed feed{limits};
    EXPECT_FALSE(feed.trips_after(6000, [](int i) { return std::min(1.0, i / 2000.0) * sine(10, 20, i); }));
    feed.next += 40;
    EXPECT_FALSE(feed.trips_after(8000, [](int i) { return sine(10, 20, i + 6040); }));
    EXPECT_TRUE(feed.trips_after(8000, [](int i) { return sine(17, 20, i + 6040); }));
}

TEST(SampleGuardTest, NonFiniteScaleTrips) {
    const auto tripped = [](const Limits& limits) {
        SampleGuard guard{{.name = "bad", .mps2_per_count = {1, NAN, 1}}, dac_rate, limits};
        Ring<Trip> ring{8};
        Warnings warnings;
        guard.check({.first = {0}, .arrived = {}}, ring, warnings);
        return ring.pop();
    };
    ASSERT_TRUE(tripped(no_levels()));
    EXPECT_EQ(tripped(no_levels())->cause, Cause::sensor_not_finite);
    EXPECT_FALSE(tripped(without(no_levels(), Cause::sensor_not_finite)));
}

DriveChange steady_drive(double f) {
    DriveChange c{.command = {.volts = {}, .frequency = f}, .first = {0}, .ramp = 2400};
    c.command.volts.at(1) = 0.5;
    c.step = turns_per_sample(f, dac_rate);
    return c;
}

TEST(SampleGuardTest, FrozenSampleTripsAfterQuarterPeriodOfDrive) {
    const auto frozen_for = [](Feed& feed, int most) -> std::optional<int> {
        AccelBlock block{.first = {}, .arrived = {}, .size = 1};
        block.counts[0] = {1234, 5, 9800};
        for (int i = 1; i <= most; ++i) {
            block.first = {feed.next++};
            feed.check(block);
            if (!feed.trips.empty()) return i;
        }
        return {};
    };
    Feed idle{no_levels()};
    EXPECT_FALSE(frozen_for(idle, 20000)) << "a base at rest under a sensor without noise";
    EXPECT_EQ(idle.warnings[Cause::sensor_frozen], 1U) << "reported after a second anyway";
    for (const double f : {20.0, 5.0, 100.0}) {
        Feed feed{no_levels()};
        feed.guard.hear(steady_drive(f));
        feed.trips_after(4000, [&](int i) { return sine(5, f, i); });
        const double allowed = std::max(16.0, rate / (4 * f));
        EXPECT_EQ(frozen_for(feed, 4000), static_cast<int>(allowed) + 1) << f << " Hz";
        EXPECT_EQ(feed.trips.at(0).cause, Cause::sensor_frozen);
        Feed off{without(no_levels(), Cause::sensor_frozen)};
        off.guard.hear(steady_drive(f));
        off.trips_after(4000, [&](int i) { return sine(5, f, i); });
        EXPECT_FALSE(frozen_for(off, 4000));
    }
}

TEST(SampleGuardTest, LatchesFirstCauseUnlessHardFollowsSoft) {
    Limits limits = no_levels();
    limits.acceleration = {20, 30};
    Feed feed{limits};
    feed.next += 1000;
    feed.add(0);
    feed.next += 1000;
    feed.add(0);
    ASSERT_EQ(feed.trips.size(), 1U) << "a soft cause after a soft one";
    feed.add(40);
    feed.add(-40);
    ASSERT_EQ(feed.trips.size(), 2U);
    EXPECT_EQ(feed.trips[0].cause, Cause::sensor_missing);
    EXPECT_EQ(feed.trips[1].cause, Cause::acceleration);
    feed.guard.rearm();
    feed.add(40);
    ASSERT_EQ(feed.trips.size(), 3U);
    EXPECT_EQ(feed.trips[2].cause, Cause::acceleration);
}

TEST(SampleGuardTest, CountsEverythingWithoutLimits) {
    Feed feed{std::nullopt};
    feed.next += 1000;
    feed.add(0);
    EXPECT_FALSE(feed.trips_after(
        8000, [](int i) { return sine(1e5, 20, i); }, 1));
    EXPECT_EQ(feed.warnings[Cause::sensor_missing], 1001U);
    EXPECT_GT(feed.warnings[Cause::transverse], 0U);
}

TEST(SampleGuardTest, UsesVectorLengthWhileAxisIsUnknown) {
    Limits limits;
    limits.acceleration = {20, 30};
    Feed feed{limits, {}};
    EXPECT_EQ(feed.trips_after(
                  10, [](int i) { return i == 5 ? 25 : 0; }, 1),
              5)
        << "25 along and 25 across";
    Feed told{limits, {}};
    told.guard.expect({.axis = {1, 0, 0}});
    EXPECT_FALSE(told.trips_after(
        10, [](int i) { return i == 5 ? 25 : 0; }, 0.1));
}

TEST(SampleGuardTest, ChecksPredictionAgainstItsOwnTolerance) {
    for (const bool right : {true, false}) {
        test::GuardBench bench{{}, test::bench_limits()};
        Expectation rough = bench.expectation(20);  // 60 % off, with a large tolerance
        for (std::complex<double>& h : rough.response) h *= 1.6;
        rough.tolerance = 0.6;
        bench.guard.expect(rough);
        bench.synth.set(bench.command({.gamma = 20}));
        bench.run(1);
        ASSERT_TRUE(bench.trips.empty()) << text(bench.trips.front());
        Expectation close = right ? bench.expectation(20) : rough;
        close.tolerance = 0.3;
        bench.guard.expect(close);
        bench.run(0.1);
        EXPECT_EQ(bench.trips.empty(), right);
    }
}

TEST(SampleGuardTest, DoesNotAllocate) {
    test::GuardBench bench{{}, test::bench_limits()};
    bench.guard.expect(bench.expectation(20));
    bench.synth.set(bench.command({.gamma = 5}));
    bench.run(0.2);
    SampleGuard& guard = bench.guard;
    AccelBlock block{.first = {bench.samples}, .arrived = {}};
    block.counts.fill({300000, 0, 60000});
    Ring<Trip> ring{8};
    const DriveChange change = steady_drive(20);
    const Expectation expectation = bench.expectation(20);
    const test::NoAlloc no_memory;
    guard.hear(change);
    guard.expect(expectation);
    for (int i = 0; i < 100; ++i) {
        guard.check(block, ring, bench.warnings);
        block.first.n += i == 50 ? 1000 : 64;
    }
    EXPECT_TRUE(ring.pop());
    guard.rearm();
}

}  // namespace
}  // namespace shaker::safety

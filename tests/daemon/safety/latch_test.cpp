// The latch of the output: what keeps it closed, what opens it, and limits that change while it drives.
#include <gtest/gtest.h>

#include <numbers>

#include "tests/support/safety/guarded.hpp"

namespace shaker::safety {
namespace {

using namespace test;

// An operator sees a trip and clears it; an abort or another trip comes before the output reads the clear.
TEST(LatchTest, ClearGivenBeforeAbortOrTripDoesNotUnlatch) {
    for (const bool abort : {true, false}) {
        Guarded run{limits()};
        run.start(0.5);
        ASSERT_TRUE(run.channels.ordered.push({.cause = Cause::residual}));
        run.go(0.5);
        ASSERT_EQ(run.trips.size(), 1U);
        run.channels.clearance.post({run.trips[0].number, run.channels.aborts});
        if (abort)
            ++run.channels.aborts;
        else
            ASSERT_TRUE(run.channels.sensed.push({.cause = Cause::sensor_open}));
        run.go(0.1);
        run.channels.drive.post(volts(0.5));
        run.go(0.5);
        EXPECT_TRUE(run.channels.stopped);
        ASSERT_EQ(run.trips.size(), 2U);
        EXPECT_EQ(run.trips[1].cause, abort ? Cause::operator_stop : Cause::sensor_open);
        EXPECT_LT(run.zero_from(), std::ssize(run.base.played) - 24000);
        run.channels.clearance.post({run.trips[1].number, run.channels.aborts});
        run.go(0.1);
        EXPECT_FALSE(run.channels.stopped) << "the operator has seen both";
    }
}

TEST(LatchTest, AbortAtRestLeavesOneTripAndLatches) {
    Guarded run{limits()};
    run.go(0.1);
    for (int i = 0; i < 3; ++i) {
        ++run.channels.aborts;
        run.go(0.1);
        EXPECT_EQ(run.channels.aborts_answered, static_cast<std::uint64_t>(i + 1));
    }
    ASSERT_EQ(run.trips.size(), 1U);
    EXPECT_EQ(run.trips[0].cause, Cause::operator_stop);
    EXPECT_TRUE(run.channels.stopped);
    // A clear from between the aborts is refused, with a trip as the answer.
    run.channels.clearance.post({run.trips[0].number, 2});
    run.go(0.1);
    EXPECT_TRUE(run.channels.stopped);
    ASSERT_EQ(run.trips.size(), 2U);
    EXPECT_EQ(run.trips[1].cause, Cause::operator_stop);
}

TEST(LatchTest, UnderrunExplainsContradictionInsideItOnly) {
    for (const std::int64_t after : {0, 4800}) {
        Guarded run{without(Cause::underrun)};
        run.start(0.5);
        run.base.empty = 100;
        const std::int64_t from = std::ssize(run.base.played);
        run.go(0.005);
        ASSERT_TRUE(run.channels.sensed.push(
            {.cause = Cause::residual, .on_dac_clock = true, .tick = from + 200 + after}));
        run.go(0.1);
        EXPECT_EQ(run.trips.size(), after == 0 ? 0U : 1U) << text(run.trips.front());
    }
}

TEST(LatchTest, LoweredDriveLimitTripsWithinABlock) {
    Guarded run{limits()};
    run.start(0.5);
    Limits lower = limits();
    lower.drive = {0.1, 0.2};
    run.channels.output_limits.post(lower);
    const std::int64_t asked = std::ssize(run.base.played);
    double step = 0;
    run.go(0.5);
    ASSERT_EQ(run.trips.size(), 1U) << "in the loudest half of a period or later in it";
    EXPECT_EQ(run.trips[0].cause, Cause::drive);
    EXPECT_EQ(run.trips[0].limit, 0.2);
    const std::int64_t period = 2400, hard_stop = 240;
    EXPECT_LE(run.zero_from(), asked + period / 2 + block + hard_stop);
    for (std::int64_t i = asked; i < std::ssize(run.base.played); ++i)
        step = std::max(step, std::abs(run.base.played[static_cast<std::size_t>(i)] -
                                       run.base.played[static_cast<std::size_t>(i - 1)]));
    EXPECT_LT(step, 0.5 * std::numbers::pi / static_cast<double>(hard_stop)) << "no step but the ramp's own";
    run.channels.clearance.post({run.trips[0].number, 0});
    run.go(0.1);
    run.channels.drive.post(volts(0.9));
    run.go(0.2);
    EXPECT_EQ(run.trips.size(), 2U);
    double largest = 0;
    for (std::size_t i = static_cast<std::size_t>(asked) + 5000; i < run.base.played.size(); ++i)
        largest = std::max(largest, std::abs(run.base.played[i]));
    EXPECT_LE(largest, 0.2) << "a command above the new limit is cut at it";
}

TEST(LatchTest, LoweredMissingTimeIsInForceAtOnce) {
    Limits patient = limits();
    patient.missing_s = 2;
    Guarded run{patient};
    run.start(0.5);
    run.channels.output_limits.post(limits());
    run.base.unplugged = true;
    const std::int64_t from = std::ssize(run.base.played);
    run.go(0.5);
    ASSERT_EQ(run.trips.size(), 1U);
    EXPECT_EQ(run.trips[0].cause, Cause::sensor_missing);
    EXPECT_LT(run.trips[0].tick, from + 2400);
}

TEST(LatchTest, HeldBackSamplesAreCheckedForTheirLevel) {
    Guarded run{limits()};
    run.base.reads_early = true;
    run.start(0.5);
    run.base.held_back = true;
    run.go(0.05);
    ASSERT_TRUE(run.trips.empty());
    run.base.gain = 60;
    const std::int64_t from = std::ssize(run.base.played);
    run.go(0.06);
    ASSERT_FALSE(run.trips.empty());
    EXPECT_EQ(run.trips[0].cause, Cause::acceleration);
    EXPECT_LE(run.zero_from(), from + 1200 + 2 * block + 240) << "half a period, two blocks, the hard stop";
}

TEST(LatchTest, LongHeldSamplesCountAsSilence) {
    Guarded run{limits()};
    run.base.reads_early = true;
    run.start(0.5);
    run.base.held_back = true;
    const std::int64_t from = std::ssize(run.base.played);
    run.go(0.5);
    ASSERT_EQ(run.trips.size(), 1U);
    EXPECT_EQ(run.trips[0].cause, Cause::sensor_missing);
    const double after_s = static_cast<double>(run.trips[0].tick - from) / rate;
    EXPECT_GT(after_s, OutputGuard::held_back_s - 0.02);
    EXPECT_LT(after_s, OutputGuard::held_back_s + 0.03);
}

TEST(LatchTest, SoftStopBeginsWithTheNextBlock) {
    Guarded run{limits()};
    DriveCommand slow = volts(0.5);
    slow.ramp_periods = 20;  // 1 s
    run.channels.drive.post(slow);
    run.go(0.6);
    run.channels.drive.post({.volts = {}, .sequence = 7, .stop_s = 0.2});
    const std::int64_t asked = std::ssize(run.base.played);
    run.go(1);
    ASSERT_TRUE(run.stop);
    EXPECT_EQ(run.stop->first.n, asked);
    EXPECT_EQ(run.stop->command.sequence, 7U);
    EXPECT_EQ(run.zero_from(), asked + 9600);
    EXPECT_TRUE(run.trips.empty()) << "a soft stop is not a trip";
    EXPECT_FALSE(run.channels.stopped);
    run.channels.drive.post(volts(0.4));
    run.go(0.5);
    EXPECT_EQ(run.zero_from(), std::ssize(run.base.played)) << "driven again without a clear";
}

TEST(LatchTest, AbortDuringSoftStopLatches) {
    Guarded run{limits()};
    run.start(0.5);
    run.channels.drive.post({.volts = {}, .sequence = 7, .stop_s = 2});
    run.go(0.1);
    ++run.channels.aborts;
    const std::int64_t asked = std::ssize(run.base.played);
    run.go(0.5);
    EXPECT_EQ(run.zero_from(), asked + 240) << "the hard stop is shorter than the rest of the soft one";
    EXPECT_TRUE(run.channels.stopped);
}

TEST(LatchTest, LatchesOperatorStopUntilRelease) {
    Guarded run{limits()};
    run.start(0.5);
    const std::int64_t asked = std::ssize(run.base.played);
    ASSERT_TRUE(run.channels.ordered.push({.cause = Cause::operator_stop}));
    run.go(0.02);
    EXPECT_TRUE(run.channels.stopped);
    run.channels.clearance.post({1, 0});  // during the ramp: answered when the drive is silent
    run.channels.drive.post(volts(0.5));
    run.go(0.01);
    EXPECT_TRUE(run.channels.stopped);
    run.go(0.5);
    EXPECT_EQ(run.zero_from(), asked + 2400);
    EXPECT_FALSE(run.channels.stopped);
    EXPECT_EQ(run.trips.size(), 1U);
    run.channels.drive.post(volts(0.4));
    run.go(1);
    EXPECT_EQ(run.zero_from(), std::ssize(run.base.played)) << "driven again";
    run.base.gain = 100;
    run.go(0.2);
    EXPECT_EQ(run.trips.size(), 2U) << "and guarded again";
}

TEST(LatchTest, HardCauseAfterSoftOneSteepensStop) {
    Guarded run{limits()};
    run.start(0.5);
    ASSERT_TRUE(run.channels.ordered.push({.cause = Cause::operator_stop}));
    ASSERT_TRUE(run.channels.sensed.push({.cause = Cause::acceleration, .stop = StopKind::hard}));
    const std::int64_t asked = std::ssize(run.base.played);
    run.go(0.2);
    ASSERT_EQ(run.trips.size(), 2U);
    EXPECT_EQ(run.zero_from(), asked + 240);
}

}  // namespace
}  // namespace shaker::safety

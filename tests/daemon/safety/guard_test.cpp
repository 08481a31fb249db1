// The guard in the loops: from the sample that violates a limit to the ramp of the drive, in played time.
#include <gtest/gtest.h>

#include <cstdio>

#include "daemon/run/run_setup.hpp"
#include "tests/support/no_alloc.hpp"
#include "tests/support/safety/guarded.hpp"

namespace shaker::safety {
namespace {

using namespace test;

TEST(GuardTest, RampBeginsWithBlockAfterTrip) {
    std::int64_t worst = 0;
    for (const std::int64_t later : {0, 3, 7, 11}) {
        Guarded run{limits()};
        run.start(0.5);
        run.go(static_cast<double>(later) * block / rate);
        run.base.gain = 60;
        std::int64_t read = 0;
        while (run.trips.empty() && run.base.played.size() < 100000) {
            read = run.read_at;
            run.go(block / rate);
        }
        ASSERT_TRUE(run.stop);
        EXPECT_EQ(run.trips.at(0).cause, Cause::acceleration);
        EXPECT_EQ(run.stop->stop, 240) << "hard: 5 ms";
        worst = std::max(worst, run.stop->first.n - read);
        run.go(0.1);
        EXPECT_EQ(run.zero_from(), run.stop->first.n + 240);
    }
    std::printf("sample read to ramp, worst of 4: %.2f ms\n", 1e3 * static_cast<double>(worst) / rate);
    EXPECT_LE(worst, block + 48) << "one block and 1 ms after the sample was read";
    Guarded off{without(Cause::acceleration)};
    off.start(0.5);
    off.base.gain = 60;
    off.go(1);
    EXPECT_TRUE(off.trips.empty());
}

TEST(GuardTest, UnpluggedAccelerometerSilencesWithin80Ms) {
    std::int64_t worst = 0;
    for (int later = 0; later < 16; ++later) {
        Guarded run{limits()};
        run.start(0.5);
        run.go(later * block / rate);
        run.base.unplugged = true;
        const std::int64_t last = 12 * run.base.filling.first.n;  // the block being filled is lost too
        run.go(0.2);
        ASSERT_EQ(run.trips.size(), 1U);
        EXPECT_EQ(run.trips[0].cause, Cause::sensor_missing);
        worst = std::max(worst, run.zero_from() - last);
        EXPECT_EQ(run.stop->stop, 2400) << "soft: 50 ms";
    }
    std::printf("last sample to silence, worst of 16: %.1f ms\n", 1e3 * static_cast<double>(worst) / rate);
    EXPECT_LE(static_cast<double>(worst) / rate, 0.080);
    Guarded off{without(Cause::sensor_missing)};
    off.start(0.5);
    off.base.unplugged = true;
    off.go(1);
    EXPECT_TRUE(off.trips.empty());
}

TEST(GuardTest, FrozenAccelerometerSilencesWithin80Ms) {
    Guarded run{limits()};
    run.start(0.5);
    run.base.gain = 0;
    run.go(0.01);
    const std::int64_t frozen = std::ssize(run.base.played);
    // Samples still arrive and are all equal.
    for (int i = 0; i < 40 && run.trips.empty(); ++i) {
        for (AccelBlock& b : run.base.ready) b.counts.fill({7, 7, 9800});
        output_step(run.output, run.dac, run.channels);
        for (AccelBlock& b : run.base.ready) b.counts.fill({7, 7, 9800});
        while (accelerometer_step(run.input, run.accelerometer, {}, run.channels)) {
        }
        run.channels.gathered = std::ssize(run.base.played);
        while (const auto t = run.channels.trips.pop()) run.trips.push_back(*t);
    }
    ASSERT_FALSE(run.trips.empty());
    EXPECT_EQ(run.trips[0].cause, Cause::sensor_frozen);
    run.go(0.1);
    EXPECT_LE(static_cast<double>(run.zero_from() - frozen) / rate, 0.08);
}

TEST(GuardTest, StalledReductionSilencesDrive) {
    Guarded run{limits()};
    run.start(0.5);
    run.reduction_lives = false;
    run.go(1);
    ASSERT_EQ(run.trips.size(), 1U);
    EXPECT_EQ(run.trips[0].cause, Cause::watchdog);
    EXPECT_LE(static_cast<double>(run.zero_from()) / rate, 1 + limits().watchdog_s + 0.05 + 0.0101);
    Guarded off{without(Cause::watchdog)};
    off.start(0.5);
    off.reduction_lives = false;
    off.go(2);
    EXPECT_TRUE(off.trips.empty());
}

// With the limits that runs play the underrun is not a trip. A correction lies in the mailbox, and more come
// from a control that has not seen the underrun yet.
TEST(GuardTest, StaysSilentAfterUnderrunDespiteCommands) {
    for (const int ramp_periods : {1, 10}) {
        Guarded run{run::limits_of_run(limits())};
        run.start(0.5);
        DriveCommand correction = volts(0.5);
        correction.ramp_periods = ramp_periods;
        run.base.empty = 1000;
        run.base.meanwhile = [&] { run.channels.drive.post(correction); };
        run.go(block / rate);
        const std::int64_t zero = run.zero_from();
        run.go(0.5);
        run.channels.drive.post(correction);
        run.go(0.5);
        EXPECT_TRUE(run.trips.empty()) << text(run.trips.front());
        EXPECT_EQ(run.zero_from(), zero) << "not a sample after it";
        EXPECT_EQ(run.channels.warnings[Cause::underrun], 1U);
        correction.underruns = 1;
        run.channels.drive.post(correction);
        run.go(1);
        EXPECT_GT(run.zero_from(), std::ssize(run.base.played) - 10) << "driven by who has seen the underrun";
    }
}

TEST(GuardTest, SoftStopIsObeyedWhateverItsAuthorHasSeen) {
    Guarded run{run::limits_of_run(limits())};
    run.base.empty = 1000;
    run.go(0.1);
    DriveCommand seen = volts(0.5);
    seen.underruns = 1;
    run.channels.drive.post(seen);
    run.go(1);
    ASSERT_GT(run.zero_from(), std::ssize(run.base.played) - 10) << "driven";
    run.channels.drive.post({.volts = {}, .sequence = 7, .stop_s = 0.1});
    const std::int64_t asked = std::ssize(run.base.played);
    run.go(0.5);
    EXPECT_EQ(run.zero_from(), asked + 4800);
}

TEST(GuardTest, UnderrunTripsWhereItIsALimit) {
    Guarded run{limits()};
    run.start(0.5);
    run.base.empty = 1000;
    run.go(block / rate);
    const std::int64_t zero = run.zero_from();
    run.channels.drive.post(volts(0.5));
    run.go(1);
    ASSERT_FALSE(run.trips.empty());
    EXPECT_EQ(run.trips[0].cause, Cause::underrun);
    EXPECT_EQ(run.zero_from(), zero) << "not a sample after it";
    EXPECT_TRUE(run.channels.stopped);
}

TEST(GuardTest, CutsAndTripsBeyondDriveLimit) {
    Limits l = limits();
    l.drive = {0.5, 0.6};
    l.acceleration = {};
    Guarded run{l};
    run.channels.drive.post(volts(0.7));
    run.go(1);
    for (const double v : run.base.played) ASSERT_LE(std::abs(v), 0.6);
    ASSERT_FALSE(run.trips.empty());
    EXPECT_EQ(run.trips[0].cause, Cause::drive);
    EXPECT_EQ(run.trips[0].limit, 0.6);
    EXPECT_GT(run.channels.warnings[Cause::drive], 0U);
    l.detectors.reset(static_cast<std::size_t>(Cause::drive));
    Guarded off{l};
    off.channels.drive.post(volts(0.7));
    off.go(1);
    EXPECT_TRUE(off.trips.empty());
}

TEST(GuardTest, TheSameRunTripsAtTheSameSample) {
    const auto played = [] {
        Guarded run{limits()};
        run.start(0.5);
        run.base.unplugged = true;
        run.go(0.3);
        return run.base.played;
    };
    EXPECT_EQ(played(), played());
}

TEST(GuardTest, StepsDoNotAllocateEvenWhenTripping) {
    Guarded run{limits()};
    run.start(0.5);
    run.base.gain = 60;
    run.base.ready.clear();
    run.base.unplugged = true;  // so it queues no blocks
    BaseAccelerometer& accelerometer = run.accelerometer;
    AccelBlock wild{.first = {run.base.filling.first.n}, .arrived = {}};
    wild.counts.fill({30000, 0, 9800});
    run.base.ready.push_back(wild);
    AccelBlock out;
    {
        const test::NoAlloc guard;
        run.input.guard.check(wild, run.channels.sensed, run.channels.warnings);
        for (int i = 0; i < 3; ++i) output_step(run.output, run.dac, run.channels);
    }
    EXPECT_TRUE(accelerometer.read(out, {}));
    EXPECT_TRUE(run.channels.stopped);
}

}  // namespace
}  // namespace shaker::safety

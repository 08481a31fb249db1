// The enable output of the amplifier: on before and during each drive, to the end of every kind of stop and
// no longer.
#include <gtest/gtest.h>

#include <cmath>

#include "daemon/acquisition/drive_output.hpp"
#include "tests/support/devices/queued_dac.hpp"
#include "tests/support/no_alloc.hpp"

namespace shaker::acquisition {
namespace {

using safety::Cause;
using safety::StopKind;

constexpr std::int64_t block = 240, queue = 2400, kept = 480, before = 12000, after = 960, period = 2400;

struct Output {
    Output() {
        for (auto* all : {&dac.given, &dac.triggers}) all->reserve(1 << 20);
        dac.tone.reserve(1 << 20);
    }
    void go(std::int64_t blocks) {
        for (std::int64_t i = 0; i < blocks; ++i) {
            output_step(output, dac, channels);
            while (channels.changes.pop()) {
            }
            while (channels.played.pop()) {
            }
            while (const auto t = channels.trips.pop()) newest = *t;
        }
    }
    void drive(double volts = 0.5, double stop_s = 0) {
        DriveCommand c;
        c.volts.at(1) = volts;
        c.stop_s = stop_s;
        c.underruns = output.underruns;
        channels.drive.post(c);
    }
    void trip(StopKind kind) { ASSERT_TRUE(channels.ordered.push({.cause = Cause::residual, .stop = kind})); }
    void release() {
        channels.clearance.post({newest.number, channels.aborts});
        go(1);
        ASSERT_FALSE(channels.stopped);
    }
    /// Sample after the last one that is not 0 in a channel.
    template <class T>
    static std::int64_t end_of(const std::vector<T>& all) {
        auto n = std::ssize(all);
        while (n > 0 && all[static_cast<std::size_t>(n - 1)] == 0) --n;
        return n;
    }
    template <class T>
    static std::int64_t start_of(const std::vector<T>& all, std::int64_t from) {
        while (from < std::ssize(all) && all[static_cast<std::size_t>(from)] == 0) ++from;
        return from;
    }
    /// The drive from sample `from` on and its tone, which ends behind it and not later than promised.
    void expect_one_tone(std::int64_t from) const {
        const std::int64_t on = start_of(dac.tone, from), first = start_of(dac.given, from);
        ASSERT_LT(first, std::ssize(dac.given)) << "driven";
        EXPECT_GE(first - on, before);
        EXPECT_LE(first - on, before + block + period);
        const std::int64_t last = end_of(dac.given), off = end_of(dac.tone);
        EXPECT_GE(off, last + after);
        EXPECT_LT(off, last + after + block);
        for (std::int64_t i = on; i < off; ++i) ASSERT_TRUE(dac.tone[static_cast<std::size_t>(i)]) << i;
    }
    test::QueuedDac dac{queue, kept, before / 48000.0};
    Channels channels{0};
    DriveOutput output{dac.info(), 20, 0, block};
    safety::Trip newest;
};

TEST(EnableTest, ToneCoversDriveAndItsStopOfAnyKind) {
    constexpr std::array stops{"soft stop",  "soft trip", "hard trip", "abort", "hard trip of a full queue",
                               "failed loop"};
    for (std::size_t i = 0; i < stops.size(); ++i) {
        SCOPED_TRACE(stops.at(i));
        Output run;
        run.go(50);
        EXPECT_EQ(Output::end_of(run.dac.tone), 0) << "nothing is driven";
        run.drive();
        run.go(100);
        run.dac.fails = i == 4;
        if (i == 0) run.drive(0, 0.3);
        if (i == 1) run.trip(StopKind::soft);
        if (i == 2 || i == 4) run.trip(StopKind::hard);
        if (i == 3) ++run.channels.aborts;
        if (i == 5) run.channels.failed = static_cast<int>(Cause::sensor_missing);
        run.go(150);
        run.expect_one_tone(0);
        EXPECT_EQ(run.dac.taken_back > 0, i == 2 || i == 3);
        if (i == 0) continue;
        const std::int64_t off = Output::end_of(run.dac.tone);
        run.drive();
        run.go(100);
        EXPECT_EQ(Output::end_of(run.dac.tone), off) << "a latched output is not enabled";
    }
}

TEST(EnableTest, ClearAloneDoesNotEnable) {
    Output run;
    run.drive();
    run.go(100);
    ++run.channels.aborts;
    run.go(100);
    const std::int64_t off = Output::end_of(run.dac.tone);
    run.release();
    run.go(100);
    EXPECT_EQ(Output::end_of(run.dac.tone), off);
    const std::int64_t now = std::ssize(run.dac.given);
    run.drive();
    run.go(100);
    run.drive(0, 0.1);
    run.go(100);
    run.expect_one_tone(now);
}

TEST(EnableTest, StopBeforeTheDriveEndsTheTone) {
    for (const bool abort : {true, false}) {
        Output run;
        run.drive();
        run.go(20);
        EXPECT_EQ(Output::end_of(run.dac.given), 0);
        if (abort)
            ++run.channels.aborts;
        else
            run.drive(0, 0.1);
        run.go(100);
        EXPECT_EQ(Output::end_of(run.dac.tone), 20 * block);
        EXPECT_EQ(Output::end_of(run.dac.given), 0) << "the command is gone";
        if (abort) run.release();
        run.go(100);
        EXPECT_EQ(Output::end_of(run.dac.tone), 20 * block);
    }
}

TEST(EnableTest, AmplifierHasItsTimeAgainAfterUnderrun) {
    Output run;
    run.drive();
    run.go(100);
    run.dac.loses = 4800;
    run.go(1);
    const std::int64_t now = std::ssize(run.dac.given);
    run.drive();
    run.go(100);
    EXPECT_GE(Output::start_of(run.dac.given, now) - Output::start_of(run.dac.tone, now), before);
}

TEST(EnableTest, UnderrunDropsTheCommandThatWasKeptBack) {
    Output run;
    run.drive();
    run.go(10);  // less than the lead
    run.dac.loses = 4800;
    run.go(200);
    EXPECT_EQ(Output::end_of(run.dac.given), 0) << "its author has not seen the underrun";
    run.drive();
    run.go(100);
    EXPECT_GT(Output::end_of(run.dac.given), 0);
}

TEST(EnableTest, NewSetPointIsNotKeptBack) {
    Output run;
    run.drive();
    run.go(100);
    run.drive(0.9);
    run.go(20);
    EXPECT_GT(*std::max_element(run.dac.given.end() - period, run.dac.given.end()), 0.85);
}

TEST(EnableTest, WithoutEnableOutputNothingIsKeptBack) {
    test::QueuedDac dac;
    Channels channels{0};
    DriveOutput output{dac.info(), 20, 0, block};
    DriveCommand c;
    c.volts.at(1) = 0.5;
    channels.drive.post(c);
    for (int i = 0; i < 100; ++i) output_step(output, dac, channels);
    EXPECT_LE(Output::start_of(dac.given, 0), 1);
    EXPECT_EQ(Output::end_of(dac.tone), 0);
}

TEST(EnableTest, DoesNotAllocate) {
    Output run;
    const test::NoAlloc guard;
    run.drive();
    run.go(100);
    ++run.channels.aborts;
    run.go(100);
}

}  // namespace
}  // namespace shaker::acquisition

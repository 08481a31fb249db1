// Hard stops take back what the DAC has queued. Stops, triggers, ticks and recorded changes stay exact.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "daemon/acquisition/drive_output.hpp"
#include "drivers/recorded/played_drive.hpp"
#include "tests/support/devices/queued_dac.hpp"
#include "tests/support/no_alloc.hpp"

namespace shaker::acquisition {
namespace {

using safety::Cause;
using safety::StopKind;

constexpr std::int64_t block = 240, queue = 2400, kept = 480, hard = 240, soft = 2400;
constexpr double frames_per_second = 997, amplitude = 0.4;

DriveCommand drive(double frequency) {
    DriveCommand c{.volts = {}, .frequency = frequency};
    c.volts.at(1) = amplitude;
    c.volts.at(2) = {0, amplitude};
    return c;
}
// Largest difference of neighbouring samples of that drive, and while a weight falls from 1 to 0.
double steepest(double frequency) { return 2 * std::numbers::pi * amplitude * 3 * frequency / 48000; }
double steepest_in(std::int64_t stop) {
    return 2 * amplitude * std::numbers::pi / 2 / static_cast<double>(stop);
}

struct Output {
    explicit Output(std::int64_t queued = queue, std::int64_t stays = kept) : dac{queued, stays} {
        dac.given.reserve(1 << 22);
        dac.triggers.reserve(1 << 22);
        dac.tone.reserve(1 << 22);
        changes.reserve(1 << 12);
    }
    void go(std::int64_t blocks) {
        for (std::int64_t i = 0; i < blocks; ++i) {
            output_step(output, dac, channels);
            while (const auto c = channels.changes.pop()) changes.push_back(*c);
            while (const auto p = channels.played.pop())
                if (p->lost > 0) lost.push_back(*p);
            while (const auto t = channels.trips.pop()) newest = *t;
        }
    }
    void trip(StopKind kind) { ASSERT_TRUE(channels.ordered.push({.cause = Cause::residual, .stop = kind})); }
    void release() {
        channels.clearance.post({newest.number, channels.aborts});
        go(1);
        ASSERT_FALSE(channels.stopped);
    }
    [[nodiscard]] std::int64_t tick() const { return output.synthesiser.tick().n; }
    [[nodiscard]] std::int64_t silent_from() const {
        std::int64_t n = std::ssize(dac.given);
        while (n > 0 && dac.given[static_cast<std::size_t>(n - 1)] == 0) --n;
        return n;
    }
    [[nodiscard]] double largest_step(std::int64_t from, std::int64_t to) const {
        double largest = 0;
        for (auto i = static_cast<std::size_t>(from); i < static_cast<std::size_t>(to); ++i)
            largest = std::max(largest, std::abs(dac.given[i] - dac.given[i - 1]));
        return largest;
    }
    /// The recorded changes give every sample, and triggers are where they belong.
    void expect_exact() const {
        ASSERT_EQ(tick(), std::ssize(dac.given));
        recorded::PlayedDrive again{dac.info(), 20, changes, lost};
        std::vector<double> volts(dac.given.size());
        again.fill(volts);
        for (std::size_t i = 0; i < volts.size(); ++i) ASSERT_EQ(dac.given[i], volts[i]) << i;
        std::int64_t k = 0;
        for (std::int64_t i = 0; i < std::ssize(dac.triggers); ++i) {
            const bool pulse = i == TriggerTrain::pulse(k, 48000, frames_per_second);
            ASSERT_EQ(dac.triggers[static_cast<std::size_t>(i)], pulse ? 1 : 0) << i;
            k += pulse ? 1 : 0;
        }
    }
    test::QueuedDac dac;
    Channels channels{0};
    DriveOutput output{dac.info(), 20, frames_per_second, block};
    std::vector<DriveChange> changes;
    std::vector<PlayTime> lost;
    safety::Trip newest;
};

TEST(TakeBackTest, ThousandTripsStopWithinMarginAndRamp) {
    std::mt19937 random{1};
    Output run;
    for (int i = 0; i < 1000; ++i) {
        const double f = 20 + static_cast<double>(random() % 80);
        run.channels.drive.post(drive(f));
        run.go(40 + static_cast<std::int64_t>(random() % 20));
        const std::int64_t heard = run.dac.played, now = run.tick();
        if (i % 2 == 0)
            ++run.channels.aborts;
        else
            run.trip(StopKind::hard);
        run.go(20);
        ASSERT_EQ(run.changes.back().taken_back, now - heard - kept);
        ASSERT_EQ(run.changes.back().first.n, heard + kept);
        ASSERT_LE(run.silent_from(), heard + kept + hard);
        ASSERT_GT(run.silent_from(), heard + kept + hard / 2);
        ASSERT_LT(run.largest_step(heard, run.tick()), steepest(f) + steepest_in(hard)) << i;
        ASSERT_LT(std::abs(run.dac.given[static_cast<std::size_t>(heard + kept)] -
                           run.dac.given[static_cast<std::size_t>(heard + kept - 1)]),
                  1.001 * steepest(f) + 1e-4)
            << "the ramp begins with the drive's slope";
        run.release();
    }
    run.expect_exact();
}

TEST(TakeBackTest, FailedTakeBackPlaysQueueThenRamp) {
    Output run;
    run.dac.fails = true;
    run.channels.drive.post(drive(20));
    run.go(60);
    const std::int64_t now = run.tick();
    ++run.channels.aborts;
    run.go(20);
    EXPECT_EQ(run.changes.back().first.n, now);
    EXPECT_EQ(run.changes.back().taken_back, 0);
    EXPECT_EQ(run.silent_from(), now + hard);
    run.expect_exact();
}

TEST(TakeBackTest, SoftStopLeavesTheQueue) {
    Output run;
    run.channels.drive.post(drive(20));
    run.go(60);
    const std::int64_t now = run.tick();
    run.trip(StopKind::soft);
    run.go(1);
    EXPECT_EQ(run.dac.taken_back, 0);
    EXPECT_EQ(run.changes.back().first.n, now);
    run.go(3);
    ++run.channels.aborts;  // while the soft stop is queued, and none of it has been played
    run.go(20);
    EXPECT_GT(run.dac.taken_back, 0);
    EXPECT_LE(run.silent_from(), now);
    run.expect_exact();
}

TEST(TakeBackTest, OperatorsTripIsAtTheStop) {
    Output run;
    run.channels.drive.post(drive(20));
    run.go(60);
    ++run.channels.aborts;
    run.go(2);
    EXPECT_EQ(run.newest.tick, run.changes.back().first.n);
}

TEST(TakeBackTest, NothingIsTakenBackAtRestOrTwice) {
    Output run;
    run.go(60);
    ++run.channels.aborts;
    run.go(60);
    EXPECT_EQ(run.dac.taken_back, 0);
    run.release();
    run.channels.drive.post(drive(20));
    run.go(60);
    ++run.channels.aborts;
    run.go(1);
    const std::int64_t taken = run.dac.taken_back;
    EXPECT_GT(taken, 0);
    run.trip(StopKind::hard);
    run.go(1);
    EXPECT_EQ(run.dac.taken_back, taken);
    run.go(60);
    run.expect_exact();
}

TEST(TakeBackTest, TakesBackNothingBeforeAnUnderrun) {
    Output run;
    run.channels.drive.post(drive(20));
    run.go(60);
    run.dac.loses = 777;
    run.go(2);
    const std::int64_t now = run.tick();
    ++run.channels.aborts;
    run.go(10);
    EXPECT_EQ(run.dac.taken_back, 0);
    EXPECT_EQ(run.changes.back().first.n, now);
}

TEST(TakeBackTest, LoweredLimitHoldsAfterwards) {
    Output run;
    run.channels.drive.post(drive(20));
    run.go(60);
    safety::Limits lower;
    lower.drive = {0.1, 0.2};
    run.channels.output_limits.post(lower);
    ++run.channels.aborts;
    run.go(20);
    run.release();
    const std::int64_t from = run.tick();
    run.channels.drive.post(drive(20));
    run.go(60);
    for (std::int64_t i = from; i < run.tick(); ++i)
        ASSERT_LE(std::abs(run.dac.given[static_cast<std::size_t>(i)]), 0.2) << i;
    EXPECT_GT(run.channels.lost.samples_clamped, 0U);
}

TEST(TakeBackTest, DoesNotAllocate) {
    Output run;
    const test::NoAlloc guard;
    for (int i = 0; i < 10; ++i) {
        run.channels.drive.post(drive(20));
        run.go(60);
        ++run.channels.aborts;
        run.go(20);
        run.release();
    }
}

// Random orders, trips of both kinds and clears, closer together than the queue is long.
TEST(TakeBackTest, RandomOrdersStayExact) {
    std::int64_t taken_back = 0;
    for (unsigned seed = 1; seed <= 20; ++seed) {
        std::mt19937 random{seed};
        const auto chance = [&](double p) { return std::uniform_real_distribution{0.0, 1.0}(random) < p; };
        const auto between = [&](double a, double b) { return std::uniform_real_distribution{a, b}(random); };
        Output run{static_cast<std::int64_t>(between(100, 9000)),
                   static_cast<std::int64_t>(between(0, 1000))};
        for (int k = 0; k < 3000; ++k) {
            if (chance(0.2)) {
                DriveCommand c = drive(between(5, 2000));
                c.sequence = static_cast<std::uint64_t>(k);
                if (chance(0.1)) c.stop_s = between(0.001, 0.1);
                run.channels.drive.post(c);
            }
            if (chance(0.02)) run.trip(StopKind::hard);
            if (chance(0.02)) run.trip(StopKind::soft);
            if (chance(0.01)) ++run.channels.aborts;
            if (chance(0.3)) run.channels.clearance.post({run.newest.number, run.channels.aborts});
            if (chance(0.05)) run.dac.fails = !run.dac.fails;
            run.go(1);
        }
        run.go(60);
        taken_back += run.dac.taken_back;
        ASSERT_NO_FATAL_FAILURE(run.expect_exact()) << seed;
    }
    EXPECT_GT(taken_back, 100'000);
}

}  // namespace
}  // namespace shaker::acquisition

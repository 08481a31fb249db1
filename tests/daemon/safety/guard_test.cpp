// The guard in the loops: from the sample that violates a limit to the ramp of the drive, in played time.
#include <gtest/gtest.h>

#include <cstdio>
#include <deque>
#include <utility>
#include <vector>

#include "daemon/acquisition/drive_output.hpp"
#include "daemon/acquisition/steps.hpp"
#include "tests/support/no_alloc.hpp"

namespace shaker::safety {
namespace {

constexpr double rate = 48000;
constexpr std::int64_t block = 240;
constexpr std::size_t most_blocks = 4000;

/// A base that follows the voltage without delay; state shared by the two devices.
struct Base {
    double gain = 20;  // m/s^2 a volt
    bool unplugged = false;
    bool reads_early = false;  // as a sensor whose samples wait for their place in time
    bool held_back = false;    // they wait
    std::vector<std::array<std::int32_t, 3>> early;
    std::int64_t empty = 0;  // duration of an underrun that the next write reports, samples
    std::vector<double> played;
    std::deque<AccelBlock> ready;
    AccelBlock filling{.first = {0}, .arrived = {}, .size = 0};

    void sample(double volts) {
        const int n = static_cast<int>(filling.first.n) + filling.size;
        filling.counts[static_cast<std::size_t>(filling.size++)] = {
            static_cast<std::int32_t>(1000 * gain * volts) + n % 2, n % 3, 9800};
        if (reads_early && !unplugged) early.push_back(filling.counts[static_cast<std::size_t>(filling.size - 1)]);
        if (filling.size < AccelBlock::capacity) return;
        if (!unplugged) ready.push_back(filling);
        filling.first.n += filling.size;
        filling.size = 0;
    }
};

class BaseDac final : public Dac {
public:
    explicit BaseDac(Base& base) : base_{base} { base_.played.reserve(most_blocks * block); }
    [[nodiscard]] DacInfo info() const override {
        return {.name = "bench", .rate_hz = rate, .full_scale_V = 1};
    }
    PlayTime write(std::span<const double> volts, std::span<const double>) override {
        const PlayTime now{{std::ssize(base_.played)}, {}, std::exchange(base_.empty, 0)};
        for (const double v : volts) {
            if (std::ssize(base_.played) % 12 == 0) base_.sample(v);
            base_.played.push_back(v);
        }
        base_.played.resize(base_.played.size() + static_cast<std::size_t>(now.lost));
        return now;
    }
    void stop() noexcept override {}

private:
    Base& base_;
};

class BaseAccelerometer final : public Accelerometer {
public:
    explicit BaseAccelerometer(Base& base) : base_{base} {}
    [[nodiscard]] AccelerometerInfo info() const override {
        return {.name = "bench", .mps2_per_count = {1e-3, 1e-3, 1e-3}, .shaker_axis = {1, 0, 0}};
    }
    bool read(AccelBlock& out, std::chrono::milliseconds) override {
        if (base_.ready.empty() || base_.held_back) return false;
        out = base_.ready.front();
        base_.ready.pop_front();
        return true;
    }
    std::size_t read_early(std::span<std::array<std::int32_t, 3>> counts) noexcept override {
        const std::size_t n = std::min(counts.size(), base_.early.size());
        std::copy_n(base_.early.begin(), n, counts.begin());
        base_.early.erase(base_.early.begin(), base_.early.begin() + static_cast<std::ptrdiff_t>(n));
        return n;
    }
    [[nodiscard]] bool ended() const noexcept override { return false; }
    void stop() noexcept override {}

private:
    Base& base_;
};

Limits limits() {
    Limits l;
    l.acceleration = {12, 15};
    l.drive = {0.8, 1};
    return l;
}

Limits without(Cause cause) {
    Limits l = limits();
    l.detectors.reset(static_cast<std::size_t>(cause));
    return l;
}

DriveCommand volts(double v) {
    DriveCommand c;
    c.volts.at(1) = v;
    return c;
}

struct Guarded {
    explicit Guarded(const Limits& l)
        : output{dac.info(), 20, 0, block, l, 4000}, input{SampleGuard{accelerometer.info(), rate, l}} {}
    /// Output, accelerometer, reduction: as the lockstep executor calls them.
    void go(double s) {
        for (const auto end = std::ssize(base.played) + std::llround(s * rate);
             std::ssize(base.played) < end;) {
            output_step(output, dac, channels);
            while (accelerometer_step(input, accelerometer, {}, channels)) read_at = std::ssize(base.played);
            if (reduction_lives) channels.gathered = std::ssize(base.played);
            while (channels.blocks.pop()) {
            }
            while (channels.played.pop()) {
            }
            while (const auto c = channels.changes.pop())
                if (c->stop > 0 && !stop) stop = *c;
            while (const auto t = channels.trips.pop()) trips.push_back(*t);
        }
    }
    /// First sample from which the drive is zero.
    [[nodiscard]] std::int64_t zero_from() const {
        auto n = std::ssize(base.played);
        while (n > 0 && base.played[static_cast<std::size_t>(n - 1)] == 0) --n;
        return n;
    }
    void start(double v) {
        trips.reserve(16);
        channels.drive.post(volts(v));
        go(1);
        EXPECT_TRUE(trips.empty()) << text(trips.at(0));
        EXPECT_GT(zero_from(), std::ssize(base.played) - 10) << "driven";
    }
    Base base;
    BaseDac dac{base};
    BaseAccelerometer accelerometer{base};
    acquisition::Channels channels{0};
    acquisition::DriveOutput output;
    acquisition::AccelerometerInput input;
    bool reduction_lives = true;
    std::int64_t read_at = 0;  // samples played when the last block was read
    std::vector<Trip> trips;
    std::optional<DriveChange> stop;
};

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

TEST(GuardTest, StaysSilentAfterUnderrunDespiteCommands) {
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

TEST(GuardTest, LatchesOperatorStopUntilRelease) {
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

// An operator sees a trip and clears it; an abort or another trip comes before the output reads the clear.
TEST(GuardTest, ClearGivenBeforeAbortOrTripDoesNotUnlatch) {
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

TEST(GuardTest, AbortAtRestLeavesOneTripAndLatches) {
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

TEST(GuardTest, UnderrunExplainsContradictionInsideItOnly) {
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

TEST(GuardTest, LoweredDriveLimitTripsWithinABlock) {
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

TEST(GuardTest, LoweredMissingTimeIsInForceAtOnce) {
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

TEST(GuardTest, HeldBackSamplesAreCheckedForTheirLevel) {
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

TEST(GuardTest, SamplesHeldBackForLongAreASilence) {
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

TEST(GuardTest, SoftStopBeginsWithTheNextBlock) {
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

TEST(GuardTest, AbortDuringSoftStopLatches) {
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

TEST(GuardTest, HardCauseAfterSoftOneSteepensStop) {
    Guarded run{limits()};
    run.start(0.5);
    ASSERT_TRUE(run.channels.ordered.push({.cause = Cause::operator_stop}));
    ASSERT_TRUE(run.channels.sensed.push({.cause = Cause::acceleration, .stop = StopKind::hard}));
    const std::int64_t asked = std::ssize(run.base.played);
    run.go(0.2);
    ASSERT_EQ(run.trips.size(), 2U);
    EXPECT_EQ(run.zero_from(), asked + 240);
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

#include "daemon/acquisition/steps.hpp"

#include <gtest/gtest.h>
#include <sched.h>

#include <chrono>
#include <thread>
#include <utility>

#include "daemon/acquisition/drive_output.hpp"
#include "daemon/acquisition/executors.hpp"
#include "tests/support/no_alloc.hpp"

namespace shaker::acquisition {
namespace {

class NullDac final : public Dac {
public:
    [[nodiscard]] DacInfo info() const override { return {"null", 48000, 1}; }
    PlayTime write(std::span<const double> volts, std::span<const double> trigger) override {
        for (const double v : volts) peak = std::max(peak, std::abs(v));
        for (const double t : trigger) pulses += t > 0.5 ? 1 : 0;
        const PlayTime played{{samples}, HostTime{std::chrono::nanoseconds{samples * 20833}}};
        samples += static_cast<std::int64_t>(volts.size());
        if (std::exchange(empty, false)) {
            samples += 1000;
            return {played.tick, played.heard, 1000};
        }
        return played;
    }
    void stop() noexcept override {}
    std::int64_t samples = 0;
    double peak = 0;
    bool empty = false;  // the next write reports an empty DAC
    int pulses = 0;
};

class NullAccelerometer final : public Accelerometer {
public:
    [[nodiscard]] AccelerometerInfo info() const override { return {.name = "null"}; }
    bool read(AccelBlock& block, std::chrono::milliseconds) override {
        block = {.first = {next}, .arrived = {}};
        next += block.size;
        return true;
    }
    [[nodiscard]] bool ended() const noexcept override { return false; }
    void stop() noexcept override {}
    std::int64_t next = 0;
};

DriveCommand one_volt() {
    DriveCommand c;
    c.volts.at(1) = 0.5;
    c.volts.at(2) = {0.1, 0.2};
    return c;
}

TEST(LoopsTest, OutputStepPlaysDriveWithoutAllocating) {
    NullDac dac;
    Channels channels{0};
    DriveOutput output{dac.info(), 20, 1000, 240};
    channels.drive.post(one_volt());
    {
        const test::NoAlloc guard;
        for (int i = 0; i < 2000; ++i) output_step(output, dac, channels);
    }
    EXPECT_GT(dac.peak, 0.4);
    EXPECT_EQ(dac.pulses, 10000);  // 10 s of 1000 frames a second
    const auto change = channels.changes.pop();
    ASSERT_TRUE(change);
    EXPECT_EQ(change->command.volts, one_volt().volts);
    const auto played = channels.played.pop();
    ASSERT_TRUE(played);
    EXPECT_EQ(played->tick.n, 0);
    EXPECT_EQ(channels.lost.plays_lost, 0U);
}

TEST(LoopsTest, EmptyDacStaysSilentUntilNewCommand) {
    NullDac dac;
    Channels channels{0};
    DriveOutput output{dac.info(), 20, 1000, 240};
    channels.drive.post(one_volt());
    for (int i = 0; i < 100; ++i) output_step(output, dac, channels);
    dac.empty = true;
    {
        const test::NoAlloc guard;
        output_step(output, dac, channels);
    }
    EXPECT_EQ(output.synthesiser.tick().n, dac.samples);  // the lost time is skipped
    dac.peak = 0;
    dac.pulses = 0;
    for (int i = 0; i < 200; ++i) output_step(output, dac, channels);
    EXPECT_EQ(dac.peak, 0);
    EXPECT_EQ(dac.pulses, 1000);
    DriveCommand again_driven = one_volt();
    again_driven.underruns = 1;
    channels.drive.post(again_driven);
    for (int i = 0; i < 20; ++i) output_step(output, dac, channels);
    EXPECT_GT(dac.peak, 0.4);
    ASSERT_TRUE(channels.changes.pop());
    const auto silence = channels.changes.pop();
    ASSERT_TRUE(silence);
    EXPECT_EQ(silence->command.volts.order(), 0);
    EXPECT_EQ(silence->ramp, 0);
    EXPECT_EQ(silence->first.n, 101 * 240 + 1000);
    const auto again = channels.changes.pop();
    ASSERT_TRUE(again);
    EXPECT_GT(again->ramp, 0);                     // up from silence by a ramp
    EXPECT_EQ(high_word(again->phase) >> 54, 0U);  // at the start of a period of the old phase, to a sample
}

TEST(LoopsTest, AccelerometerStepPassesOnOrCountsBlocks) {
    NullAccelerometer device;
    Channels channels{0};
    AccelerometerInput input{safety::SampleGuard{device.info(), 48000, safety::Limits{}}};
    {
        const test::NoAlloc guard;
        for (int i = 0; i < 1100; ++i) accelerometer_step(input, device, {}, channels);
    }
    int got = 0;
    while (channels.blocks.pop()) ++got;
    EXPECT_EQ(got, 1024);
    EXPECT_EQ(channels.lost.blocks_lost, 76U);
}

TEST(ExecutorsTest, LockstepRunsOtherLoopsToIdleAfterEachStep) {
    std::string order;
    int queued = 0, rounds = 0;
    std::vector<Loop> loops{{"first", 0, true,
                             [&](std::chrono::milliseconds) {
                                 order += 'A';
                                 queued = 2;
                                 ++rounds;
                                 return true;
                             }},
                            {"second", 0, true, [&](std::chrono::milliseconds) {
                                 if (queued == 0) return false;
                                 order += 'b';
                                 --queued;
                                 return true;
                             }}};
    run_lockstep(loops, [&] { return rounds == 3; });
    EXPECT_EQ(order, "AbbAbbAbb");
}

TEST(ExecutorsTest, ExceptionInThreadEndsRunAndIsRethrown) {
    std::atomic<bool> unblocked{false};
    std::vector<Loop> loops{
        {"fails", 0, true, [](std::chrono::milliseconds) -> bool { throw std::runtime_error{"gone"}; }},
        {"waits", 0, false, [](std::chrono::milliseconds) { return false; }}};
    try {
        run_threaded(
            loops, [] { return false; }, [&] { unblocked = true; });
        FAIL() << "nothing was thrown";
    } catch (const std::runtime_error& e) {
        EXPECT_STREQ(e.what(), "gone");
    }
    EXPECT_TRUE(unblocked);
}

TEST(ExecutorsTest, ALoopThatNeverWaitsLosesItsPriority) {
    using Clock = std::chrono::steady_clock;
    int before = -1, after = -1;
    std::vector<RealTimeGrant> grants;
    std::vector<Loop> loops{{"spins", 1, true, [&](std::chrono::milliseconds) {
                                 before = sched_getscheduler(0);
                                 const auto until = Clock::now() + std::chrono::seconds{2};
                                 do after = sched_getscheduler(0);
                                 while (after == SCHED_FIFO && Clock::now() < until);
                                 return true;
                             }}};
    run_threaded(
        loops, [&] { return before >= 0; }, [] {},
        {.begun = [&](const std::vector<RealTimeGrant>& g) { grants = g; }});
    ASSERT_EQ(grants.size(), 2);
    if (!grants.back().refused.empty()) GTEST_SKIP() << grants.back().refused;
    EXPECT_EQ(before, SCHED_FIFO);
    EXPECT_EQ(after, SCHED_OTHER);
}

// After a pause of the computer virtual time must not run faster than the threads can follow.
TEST(PacerTest, LongPauseIsNotMadeUpFor) {
    using Clock = std::chrono::steady_clock;
    Pacer pacer;
    pacer.wait_until(1);
    std::this_thread::sleep_for(std::chrono::milliseconds{100});
    const auto before = Clock::now();
    pacer.wait_until(1.005);
    pacer.wait_until(1.065);
    EXPECT_GE(std::chrono::duration<double>(Clock::now() - before).count(), 0.06);
}

}  // namespace
}  // namespace shaker::acquisition

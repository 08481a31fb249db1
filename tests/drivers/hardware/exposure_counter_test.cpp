#include "drivers/hardware/clock/exposure_counter.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace shaker::hardware {
namespace {

constexpr std::int64_t period = 5'000'000;  // 200 pictures a second
constexpr std::int64_t pause = 1'000'000'000;

ExposureSign sign(std::optional<std::uint64_t> id, double stamp_periods, double host_periods) {
    const auto ns = [](double periods) { return std::llround(periods * static_cast<double>(period)); };
    return {id, CameraStamp{ns(stamp_periods)}, HostTime{std::chrono::nanoseconds{ns(host_periods)}}};
}

ExposureCounter free_running() { return {ExposureCounter::Ids::wrap_at_65535, period, 0}; }
ExposureCounter triggered() { return {ExposureCounter::Ids::wrap_at_65535, period, pause}; }

TEST(ExposureCounterTest, PicturesInOrderAreCountedOneByOne) {
    ExposureCounter counter = free_running();
    for (int i = 0; i < 10; ++i) {
        const auto place = counter.next(sign(static_cast<std::uint64_t>(7 + i), i, i));
        EXPECT_EQ(place.tick.n, i);
        EXPECT_EQ(place.missed, 0);
        EXPECT_FALSE(place.gap);
    }
}

TEST(ExposureCounterTest, AMissingIdIsAMissedExposure) {
    ExposureCounter counter = free_running();
    counter.next(sign(10, 0, 0));
    const auto place = counter.next(sign(14, 4, 4));
    EXPECT_EQ(place.tick.n, 4);
    EXPECT_EQ(place.missed, 3);
    EXPECT_TRUE(place.gap);
}

TEST(ExposureCounterTest, IdsOf16BitsGoFrom65535To1) {
    ExposureCounter counter = free_running();
    counter.next(sign(65534, 0, 0));
    EXPECT_EQ(counter.next(sign(65535, 1, 1)).missed, 0);
    EXPECT_EQ(counter.next(sign(1, 2, 2)).missed, 0);
    EXPECT_EQ(counter.next(sign(3, 4, 4)).missed, 1);
    counter = free_running();
    counter.next(sign(65535, 0, 0));
    EXPECT_EQ(counter.next(sign(2, 2, 2)).missed, 1);
}

TEST(ExposureCounterTest, WideIdsDoNotWrap) {
    ExposureCounter counter{ExposureCounter::Ids::wide, period, 0};
    counter.next(sign(65535, 0, 0));
    EXPECT_EQ(counter.next(sign(65536, 1, 1)).missed, 0);
    EXPECT_EQ(counter.next(sign(65538, 3, 3)).missed, 1);
}

TEST(ExposureCounterTest, IdsBeyond16BitsAreTakenAsWide) {
    ExposureCounter counter = free_running();
    counter.next(sign(70000, 0, 0));
    EXPECT_EQ(counter.next(sign(70002, 2, 2)).missed, 1);
}

TEST(ExposureCounterTest, StampsShowSkippedExposure) {
    ExposureCounter counter = free_running();
    counter.next(sign(1, 0, 0));
    const auto place = counter.next(sign(2, 3.02, 3));
    EXPECT_EQ(place.missed, 2);
    EXPECT_EQ(place.tick.n, 3);
}

TEST(ExposureCounterTest, WithoutIdsTheStampsCount) {
    ExposureCounter counter = free_running();
    counter.next(sign(0, 0, 0));
    EXPECT_EQ(counter.next(sign(0, 1, 1)).missed, 0);
    EXPECT_EQ(counter.next(sign(0, 4, 4)).missed, 2);
}

TEST(ExposureCounterTest, LatePictureIsNoGap) {
    ExposureCounter counter = free_running();
    counter.next(sign(1, 0, 0));
    const auto late = counter.next(sign(2, 1, 300));  // 1.5 s late
    EXPECT_EQ(late.tick.n, 1);
    EXPECT_FALSE(late.gap);
    EXPECT_FALSE(late.clock_jumped);
    EXPECT_FALSE(counter.next(sign(3, 2, 300.1)).gap);
}

TEST(ExposureCounterTest, AStepOfTheCamerasClockIsNotALoss) {
    for (const double jump : {1000.0, -1000.0}) {
        ExposureCounter counter = free_running();
        counter.next(sign(1, 0, 0));
        const auto place = counter.next(sign(2, 1 + jump, 1));
        EXPECT_EQ(place.tick.n, 1) << jump;
        EXPECT_EQ(place.missed, 0) << jump;
        EXPECT_TRUE(place.clock_jumped) << jump;
        EXPECT_TRUE(place.gap) << jump;
        EXPECT_FALSE(counter.next(sign(3, 2 + jump, 2)).gap) << jump;
    }
}

TEST(ExposureCounterTest, SilenceIsLossIfFreeRunningPauseIfTriggered) {
    ExposureCounter counter = free_running();
    counter.next(sign(1, 0, 0));
    EXPECT_EQ(counter.next(sign(2, 400, 400)).missed, 399);

    counter = triggered();
    counter.next(sign(1, 0, 0));
    const auto place = counter.next(sign(2, 400, 400));
    EXPECT_EQ(place.tick.n, 1);
    EXPECT_EQ(place.missed, 0);
    EXPECT_TRUE(place.gap);
    EXPECT_EQ(counter.next(sign(3, 403, 403)).missed, 2);
}

TEST(ExposureCounterTest, StampsContinueAfterReopeningIfClockDid) {
    ExposureCounter counter = free_running();
    counter.next(sign(500, 0, 0));
    counter.reopened();
    const auto place = counter.next(sign(1, 300, 310));
    EXPECT_EQ(place.tick.n, 300);
    EXPECT_EQ(place.missed, 299);
    EXPECT_TRUE(place.gap);
}

TEST(ExposureCounterTest, HostClockCountsAfterCameraRestart) {
    ExposureCounter counter = free_running();
    counter.next(sign(500, 10000, 0));
    counter.reopened();
    const auto place = counter.next(sign(1, 0, 300.2));
    EXPECT_EQ(place.tick.n, 300);
    EXPECT_TRUE(place.gap);
    EXPECT_FALSE(counter.next(sign(2, 1, 301)).gap);
}

}  // namespace
}  // namespace shaker::hardware

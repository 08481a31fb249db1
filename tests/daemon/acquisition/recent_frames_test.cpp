#include "daemon/acquisition/recent_frames.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace shaker::acquisition {
namespace {

Frame frame(std::int64_t tick) {
    Frame f;
    f.tick = {tick};
    f.width = 6;
    f.height = 4;
    f.pixels.assign(24, static_cast<std::byte>(tick % 251));
    return f;
}

void expect_run(const RecentFrames& tail, std::int64_t first, std::int64_t last) {
    ASSERT_EQ(static_cast<std::int64_t>(tail.size()), last - first + 1);
    for (std::size_t i = 0; i < tail.size(); ++i) {
        const std::int64_t tick = first + static_cast<std::int64_t>(i);
        EXPECT_EQ(tail[i].tick.n, tick);
        EXPECT_EQ(tail[i].pixels, frame(tick).pixels);
    }
}

TEST(RecentFramesTest, KeepsNewestFramesUnchanged) {
    RecentFrames tail{100};
    for (std::int64_t n = 0; n < 1000; ++n) tail.push(frame(n));
    expect_run(tail, 1000 - 220, 999);  // 2.2 s
    EXPECT_FALSE(tail.whole());
}

TEST(RecentFramesTest, TripKeepsFramesBeforeAndAddsFramesAfter) {
    RecentFrames tail{100};
    for (std::int64_t n = 0; n < 300; ++n) tail.push(frame(n));
    tail.hold();
    for (std::int64_t n = 300; n < 330; ++n) tail.push(frame(n));
    expect_run(tail, 80, 329);
    for (std::int64_t n = 330; n < 1000; ++n) tail.push(frame(n));
    expect_run(tail, 80, 349);  // 0.5 s of room
    EXPECT_EQ(tail.lost(), 650U);
}

TEST(RecentFramesTest, ContinuedRunStartsNewTail) {
    RecentFrames tail{100};
    for (std::int64_t n = 0; n < 300; ++n) tail.push(frame(n));
    tail.hold();
    for (std::int64_t n = 300; n < 330; ++n) tail.push(frame(n));
    for (std::int64_t n = 330; n < 400; ++n) tail.push(frame(n));
    tail.release();
    for (std::int64_t n = 400; n < 700; ++n) tail.push(frame(n));
    expect_run(tail, 480, 699);
    EXPECT_EQ(tail.lost(), 0U) << "of the new tail";
    EXPECT_FALSE(tail.whole());
}

TEST(RecentFramesTest, ShortRunIsComplete) {
    RecentFrames tail{100};
    for (std::int64_t n = 0; n < 5; ++n) tail.push(frame(n));
    tail.hold();
    tail.push(frame(5));
    expect_run(tail, 0, 5);
    EXPECT_TRUE(tail.whole());
}

TEST(RecentFramesTest, MemoryIsBoundedByRateAndSize) {
    RecentFrames tail{100};
    EXPECT_EQ(tail.capacity(), 270U);
    EXPECT_EQ(tail.bytes(), 0U);  // no allocation before the first frame
    std::size_t most = 0;
    for (std::int64_t n = 0; n < 5000; ++n) {
        if (n == 4000) tail.hold();
        tail.push(frame(n));
        most = std::max(most, tail.bytes());
    }
    EXPECT_EQ(most, 2U << 20U);  // 270 x 24 bytes in one piece
}

TEST(RecentFramesTest, MemoryMatchesNumberOfPictures) {
    RecentFrames tail{100};
    Frame big = frame(0);
    big.width = 640;
    big.height = 200;
    big.pixels.assign(128000, std::byte{1});
    tail.push(big);
    EXPECT_EQ(tail.bytes(), 16U << 20U);  // no more than is needed
    std::size_t most = 0;
    for (int n = 0; n < 2000; ++n) {
        if (n == 1500) tail.hold();
        tail.push(big);
        most = std::max(most, tail.bytes());
    }
    EXPECT_GE(most, 270U * 128000);
    EXPECT_LE(most, 270U * 128000 + (16U << 20U));
}

TEST(RecentFramesTest, FrameOfOtherSizeIsCountedNotKept) {
    RecentFrames tail{100};
    tail.push(frame(0));
    Frame other = frame(1);
    other.pixels.resize(25);
    tail.push(other);
    tail.push(frame(2));
    ASSERT_EQ(tail.size(), 2U);
    EXPECT_EQ(tail[1].tick.n, 2);
    EXPECT_EQ(tail.lost(), 1U);
}

TEST(RecentFramesTest, CameraWithoutRateKeepsNewestFrame) {
    RecentFrames tail{0};
    tail.push(frame(1));
    tail.push(frame(2));
    expect_run(tail, 2, 2);
}

}  // namespace
}  // namespace shaker::acquisition

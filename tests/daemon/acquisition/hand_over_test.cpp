#include <gtest/gtest.h>

#include "daemon/acquisition/streams.hpp"

namespace shaker::acquisition {
namespace {

// 100 s with one stamp, one block and one track per second, and a change of the drive every 10 s.
Streams hundred_seconds() {
    Streams s;
    s.dac_rate_hz = 1000;
    s.accelerometer.rate_hz = 100;
    s.tracks.push_back({"top", {}, {}});
    for (int t = 0; t < 100; ++t) {
        PlayTime played{};
        played.tick = {1000 * t};
        s.played.push_back(played);
        AccelBlock block{};
        block.first = {100 * t};
        s.blocks.push_back(block);
        tracking::Track track{};
        track.time = master_time(t);
        s.tracks[0].tracks.push_back(track);
        if (t % 10 != 0) continue;
        DriveChange change{};
        change.first = {1000 * t};
        s.changes.push_back(change);
    }
    s.trips.resize(2);
    s.dropped.blocks = 7;
    return s;
}

TEST(HandOverTest, KeepsTheEndAndCountsTheRestAsDropped) {
    Streams s = hundred_seconds();
    const Streams all = hand_over(s, 85);
    EXPECT_EQ(all.played.size(), 100U);
    EXPECT_EQ(all.blocks.size(), 100U);
    EXPECT_EQ(all.tracks[0].tracks.size(), 100U);
    ASSERT_EQ(s.played.size(), 15U);
    EXPECT_EQ(s.played.front().tick.n, 85000);
    EXPECT_EQ(s.dropped.played, 85U);
    EXPECT_EQ(s.dropped.blocks + s.blocks.size(), 107U);
    EXPECT_EQ(s.tracks[0].dropped + s.tracks[0].tracks.size(), 100U);
    EXPECT_EQ(s.trips.size(), 2U) << "trips are counted from the first";
    ASSERT_EQ(s.changes.size(), 2U);
    EXPECT_EQ(s.changes.front().first.n, 80000) << "the drive in force at 85 s";
    EXPECT_EQ(s.dropped.changes, 8U);
}

TEST(HandOverTest, MovesEverythingWhenNothingIsKept) {
    Streams s = hundred_seconds();
    const Streams all = hand_over(s, INFINITY);
    EXPECT_EQ(all.blocks.size(), 100U);
    EXPECT_TRUE(s.blocks.empty());
    EXPECT_TRUE(s.played.empty());
    EXPECT_EQ(s.dropped.played, 100U);
    EXPECT_EQ(s.changes.size(), 1U) << "the drive in force";
}

// A recording that starts later than the bench is reduced by its own stamps only; the bench keeps its clocks.
TEST(HandOverTest, TheTimeBaseOfARecordingHasItsStampsOnly) {
    Streams s;
    s.dac_rate_hz = 1000;
    s.timebase = empty_timebase(s);
    const auto play = [&](int t) { add(s, PlayTime{{1000 * t}, HostTime{std::chrono::seconds{t}}, 0}); };
    for (int t = 0; t < 50; ++t) play(t);
    forget(s);
    for (int t = 50; t < 60; ++t) play(t);
    const Streams recorded = hand_over(s, INFINITY);
    EXPECT_EQ(recorded.timebase.recorded().dac().stamps, 10U);
    EXPECT_EQ(s.timebase.recorded().dac().stamps, 60U);
    EXPECT_TRUE(s.timebase.recorded().dac_ready());
}

}  // namespace
}  // namespace shaker::acquisition

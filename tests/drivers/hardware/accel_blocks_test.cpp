#include "drivers/hardware/iio/accel_blocks.hpp"

#include <gtest/gtest.h>

namespace shaker::iio {
namespace {

constexpr AccelBlocks::Limits wide{{{-100, 100}, {-100, 100}, {-100, 100}}};

// A host that reads late before a break hides how long the break was.
TEST(AccelBlocksTest, GapIsMarkedWithoutCountedLoss) {
    AccelBlocks blocks{wide, 4};
    for (int i = 0; i < 6; ++i) blocks.add(i, 0, {}, {});
    blocks.begin_after_gap();
    for (int i = 6; i < 10; ++i) blocks.add(i, 0, {}, {});
    const auto full = blocks.take(), ended = blocks.take(), after = blocks.take();
    ASSERT_TRUE(full && ended && after);
    EXPECT_EQ(full->size, 4);
    EXPECT_EQ(ended->size, 2);
    EXPECT_FALSE(has(ended->quality, Quality::gap));
    EXPECT_EQ(after->first.n, 6);
    EXPECT_TRUE(has(after->quality, Quality::gap));
    EXPECT_EQ(blocks.lost(), 0U);
}

TEST(AccelBlocksTest, LossMovesTheTickAndIsMarked) {
    AccelBlocks blocks{wide, 2};
    blocks.add(0, 0, {}, {});
    blocks.add(4, 3, {}, {});
    blocks.add(5, 0, {}, {});
    ASSERT_TRUE(blocks.take());
    const auto after = blocks.take();
    ASSERT_TRUE(after);
    EXPECT_EQ(after->first.n, 4);
    EXPECT_TRUE(has(after->quality, Quality::gap));
    EXPECT_EQ(blocks.lost(), 3U);
}

}  // namespace
}  // namespace shaker::iio

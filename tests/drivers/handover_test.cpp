#include "drivers/handover.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <thread>

#include "drivers/data.hpp"
#include "drivers/synthesiser.hpp"
#include "tests/support/nightly.hpp"
#include "tests/support/no_alloc.hpp"

namespace shaker {
namespace {

TEST(RingTest, KeepsOrderAndReportsFull) {
    Ring<int> ring{3};
    EXPECT_FALSE(ring.pop().has_value());
    for (int round = 0; round < 5; ++round) {  // wraps around its storage
        EXPECT_TRUE(ring.push(1));
        EXPECT_TRUE(ring.push(2));
        EXPECT_TRUE(ring.push(3));
        EXPECT_FALSE(ring.push(4));
        EXPECT_EQ(ring.pop(), 1);
        EXPECT_TRUE(ring.push(5));
        EXPECT_EQ(ring.pop(), 2);
        EXPECT_EQ(ring.pop(), 3);
        EXPECT_EQ(ring.pop(), 5);
        EXPECT_FALSE(ring.pop().has_value());
    }
}

TEST(RingTest, ReleasesResourcesAtPop) {
    Ring<std::shared_ptr<int>> ring{2};
    const auto value = std::make_shared<int>(7);
    ASSERT_TRUE(ring.push(value));
    EXPECT_EQ(value.use_count(), 2);
    EXPECT_EQ(**ring.pop(), 7);
    EXPECT_EQ(value.use_count(), 1);
}

TEST(RingTest, DestroysUnreadValues) {
    const auto value = std::make_shared<int>(7);
    {
        Ring<std::shared_ptr<int>> ring{2};
        ASSERT_TRUE(ring.push(value));
    }
    EXPECT_EQ(value.use_count(), 1);
}

TEST(RingTest, LosesAndReordersNothingBetweenTwoThreads) {
    const int count = SHAKER_SANITIZED != 0 && !test::nightly() ? 40000 : 200000;
    Ring<AccelBlock> ring{64};
    std::thread writer{[&] {
        AccelBlock block;
        for (int i = 0; i < count; ++i) {
            block.first.n = i;
            block.counts.back()[2] = i;
            while (!ring.push(block)) std::this_thread::yield();
        }
    }};
    int wrong = 0;
    for (int i = 0; i < count;) {
        const auto block = ring.pop();
        if (!block) {
            std::this_thread::yield();
            continue;
        }
        wrong += block->first.n != i || block->counts.back()[2] != i;
        ++i;
    }
    writer.join();
    EXPECT_EQ(wrong, 0);
    EXPECT_FALSE(ring.pop().has_value());
}

TEST(RingTest, DoesNotAllocate) {
    Ring<AccelBlock> ring{4};
    const AccelBlock block;
    int taken = 0;
    {
        const test::NoAlloc guard;
        for (int i = 0; i < 100; ++i) {
            while (ring.push(block)) {
            }
            while (ring.pop()) ++taken;
        }
    }
    EXPECT_EQ(taken, 400);
}

TEST(MailboxTest, ReturnsNewestValueOnce) {
    Mailbox<int> box;
    EXPECT_FALSE(box.take().has_value());
    box.post(1);
    EXPECT_EQ(box.take(), 1);
    EXPECT_FALSE(box.take().has_value());
    for (int i = 2; i < 10; ++i) box.post(i);
    EXPECT_EQ(box.take(), 9);
    EXPECT_FALSE(box.take().has_value());
}

/// Much larger than any atomic, with equal words, so that an inconsistent copy is detected.
struct Large {
    std::array<std::uint64_t, 100> words{};
};

TEST(MailboxTest, NeverTearsNorGoesBackBetweenTwoThreads) {
    constexpr std::uint64_t count = 200000;
    Mailbox<Large> box;
    std::thread writer{[&] {
        Large value;
        for (std::uint64_t i = 1; i <= count; ++i) {
            value.words.fill(i);
            box.post(value);
        }
    }};
    std::uint64_t last = 0;
    int torn = 0;
    int backwards = 0;
    while (last < count) {
        const auto value = box.take();
        if (!value) continue;
        for (const std::uint64_t word : value->words) torn += word != value->words.front();
        backwards += value->words.front() <= last;
        last = value->words.front();
    }
    writer.join();
    EXPECT_EQ(torn, 0);
    EXPECT_EQ(backwards, 0);
    EXPECT_FALSE(box.take().has_value());
}

TEST(MailboxTest, CarriesADriveCommandWithoutAllocating) {
    Mailbox<DriveCommand> box;
    DriveCommand command;
    command.volts.at(16) = {1, 2};
    command.sequence = 99;
    std::optional<DriveCommand> taken;
    {
        const test::NoAlloc guard;
        box.post(command);
        taken = box.take();
    }
    ASSERT_TRUE(taken.has_value());
    EXPECT_EQ(taken->volts, command.volts);
    EXPECT_EQ(taken->sequence, 99U);
}

}  // namespace
}  // namespace shaker

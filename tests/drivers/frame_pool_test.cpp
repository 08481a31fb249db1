#include "drivers/frame_pool.hpp"

#include <gtest/gtest.h>

#include <array>
#include <optional>
#include <set>
#include <thread>
#include <vector>

#include "drivers/errors.hpp"
#include "drivers/handover.hpp"
#include "tests/support/nightly.hpp"
#include "tests/support/no_alloc.hpp"

namespace shaker {
namespace {

TEST(FramePoolTest, ReturnsNullWhenAllBuffersAreInUse) {
    FramePool pool{3, 8, 4, 2};
    std::vector<FramePtr> held;
    std::set<const std::byte*> buffers;
    for (int i = 0; i < 3; ++i) {
        const auto frame = pool.acquire();
        ASSERT_NE(frame, nullptr);
        EXPECT_EQ(frame->pixels.size(), 64U);
        EXPECT_EQ(frame->view().width, 8);
        EXPECT_EQ(frame->view().bytes_per_pixel, 2);
        buffers.insert(frame->pixels.data());
        held.push_back(frame);
    }
    EXPECT_EQ(buffers.size(), 3U);
    EXPECT_EQ(pool.acquire(), nullptr);
    EXPECT_EQ(pool.acquire(), nullptr);
    EXPECT_EQ(pool.exhausted(), 2U);
    const std::byte* returned = held[1]->pixels.data();
    held.erase(held.begin() + 1);
    const auto again = pool.acquire();
    ASSERT_NE(again, nullptr);
    EXPECT_EQ(again->pixels.data(), returned);
    EXPECT_EQ(pool.exhausted(), 2U);
}

TEST(FramePoolTest, ReusedFrameHasDefaultFields) {
    FramePool pool{1, 4, 4, 1};
    auto frame = pool.acquire();
    frame->tick.n = 5;
    frame->arrived = HostTime{std::chrono::nanoseconds{7}};
    frame->stamp = CameraStamp{8};
    frame->mid_exposure = master_time(3);
    frame->quality = Quality::gap;
    frame.reset();
    frame = pool.acquire();
    ASSERT_NE(frame, nullptr);
    EXPECT_EQ(frame->tick.n, 0);
    EXPECT_EQ(frame->arrived, HostTime{});
    EXPECT_FALSE(frame->stamp.has_value());
    EXPECT_FALSE(frame->mid_exposure.has_value());
    EXPECT_EQ(frame->quality, Quality::good);
}

TEST(FramePoolTest, WeakPointerPreventsReuse) {
    FramePool pool{1, 4, 4, 1};
    FramePtr frame = pool.acquire();
    std::weak_ptr<const Frame> watcher = frame;
    frame.reset();
    EXPECT_TRUE(watcher.expired());
    EXPECT_EQ(pool.acquire(), nullptr);
    watcher.reset();
    EXPECT_NE(pool.acquire(), nullptr);
}

TEST(FramePoolTest, FramesOutliveThePool) {
    std::optional<FramePool> pool{std::in_place, 2, 4, 4, 1};
    auto frame = pool->acquire();
    frame->pixels[3] = std::byte{9};
    FramePtr kept = std::move(frame);
    pool.reset();
    EXPECT_EQ(kept->pixels[3], std::byte{9});
    kept.reset();  // memory checkers verify that all memory is returned once
}

TEST(FramePoolTest, FramesReturnFromAnotherThread) {
    const int count = SHAKER_SANITIZED != 0 && !test::nightly() ? 20000 : 100000;
    FramePool pool{8, 4, 4, 1};
    Ring<FramePtr> ring{4};
    std::thread reader{[&] {
        std::int64_t next = 0;
        int wrong = 0;
        while (next < count) {
            const auto frame = ring.pop();
            if (!frame) {
                std::this_thread::yield();
                continue;
            }
            wrong += (*frame)->tick.n != next || (*frame)->pixels[0] != std::byte(next & 255);
            ++next;
        }
        EXPECT_EQ(wrong, 0);
    }};
    for (std::int64_t i = 0; i < count; ++i) {
        std::shared_ptr<Frame> frame;
        while (!(frame = pool.acquire())) std::this_thread::yield();
        frame->tick.n = i;
        frame->pixels[0] = std::byte(i & 255);
        while (!ring.push(frame)) std::this_thread::yield();
    }
    reader.join();
    for (int i = 0; i < 2; ++i) {  // all frames are back and usable
        std::array<FramePtr, 8> all;
        for (FramePtr& frame : all) frame = pool.acquire();
        for (const FramePtr& frame : all) EXPECT_NE(frame, nullptr);
    }
}

TEST(FramePoolTest, RefusesSizesThatAreNotPositive) {
    EXPECT_THROW((FramePool{0, 4, 4, 1}), InputError);
    EXPECT_THROW((FramePool{1, -4, 4, 1}), InputError);
    EXPECT_THROW((FramePool{1, 4, 0, 1}), InputError);
    EXPECT_THROW((FramePool{1, 4, 4, 0}), InputError);
}

TEST(FramePoolTest, NeitherAllocatesNorFrees) {
    FramePool pool{2, 640, 480, 1};
    const test::NoAlloc guard;
    for (int i = 0; i < 10; ++i) {
        const FramePtr one = pool.acquire();
        const FramePtr two = pool.acquire();
        const FramePtr none = pool.acquire();
        FramePtr shared = one;
        shared = two;
    }
}

}  // namespace
}  // namespace shaker

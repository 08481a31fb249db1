#include "tests/support/no_alloc.hpp"

#include <gtest/gtest-spi.h>
#include <gtest/gtest.h>

#include <array>
#include <cstdlib>
#include <memory>
#include <new>
#include <string>
#include <thread>

namespace shaker::test {
namespace {

// The compiler may leave out a pair of new and delete that nobody sees; a volatile pointer is seen.
void* volatile seen = nullptr;

TEST(NoAllocTest, SeesEveryFormOfNewAndDelete) {
    struct alignas(64) Wide {
        std::array<char, 64> bytes;
    };
    const HeapCalls before = heap_calls();
    auto* one = new int{1};
    seen = one;
    delete one;
    auto* several = new int[7]{};
    seen = several;
    delete[] several;
    auto* quiet = new (std::nothrow) int{1};
    seen = quiet;
    delete quiet;
    auto* wide = new Wide{};
    seen = wide;
    delete wide;
    const HeapCalls after = heap_calls();
    EXPECT_GE(after.taken - before.taken, 4U);
    EXPECT_GE(after.returned - before.returned, 4U);
}

TEST(NoAllocTest, SeesMallocOfLibraries) {
    const HeapCalls before = heap_calls();
    seen = std::malloc(100);
    std::free(seen);
    const HeapCalls after = heap_calls();
    EXPECT_EQ(after.taken - before.taken, 1U);
    EXPECT_EQ(after.returned - before.returned, 1U);
}

TEST(NoAllocTest, FailsTheTestOnAllocationAndOnFreeing) {
    EXPECT_NONFATAL_FAILURE(
        {
            auto kept = std::make_unique<std::string>();
            const NoAlloc guard;
            *kept = std::string(1000, 'x');
        },
        "memory was allocated");
    EXPECT_NONFATAL_FAILURE(
        {
            auto given = std::make_unique<int>(3);
            seen = given.get();
            const NoAlloc guard;
            given.reset();
        },
        "memory was freed");
}

TEST(NoAllocTest, WatchesItsOwnThreadOnly) {
    HeapCalls before;
    HeapCalls after;
    std::thread other{[&] {
        before = heap_calls();
        seen = std::malloc(10);
        std::free(seen);
        after = heap_calls();
    }};
    other.join();
    EXPECT_EQ(after.taken - before.taken, 1U);
    const NoAlloc guard;
}

}  // namespace
}  // namespace shaker::test

#pragma once
// Proof that a stretch of code touches no heap: what functions marked "Real-time" are tested with.
#include <cstdint>

namespace shaker::test {

/// Heap calls made by this thread since it started.
struct HeapCalls {
    std::uint64_t taken = 0;     // malloc, calloc, realloc, aligned_alloc, operator new
    std::uint64_t returned = 0;  // free, operator delete, of something that was not null
};
HeapCalls heap_calls() noexcept;

/// Fails the current test if this thread took memory from the heap or returned some during the guard's life.
/// Other threads are not watched: give each its own guard.
class NoAlloc {
public:
    NoAlloc() noexcept : before_{heap_calls()} {}
    NoAlloc(const NoAlloc&) = delete;
    NoAlloc& operator=(const NoAlloc&) = delete;
    ~NoAlloc();

private:
    HeapCalls before_;
};

}  // namespace shaker::test

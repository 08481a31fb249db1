#pragma once
// Proof that code does not use the heap: for tests of functions marked "Real-time".
#include <cstdint>

namespace shaker::test {

/// Heap calls of this thread since its start.
struct HeapCalls {
    std::uint64_t taken = 0;     // malloc, calloc, realloc, aligned_alloc, operator new
    std::uint64_t returned = 0;  // free, operator delete, not counting null
};
HeapCalls heap_calls() noexcept;

/// Fails the current test if this thread allocates or frees memory while the guard exists.
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

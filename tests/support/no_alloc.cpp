#include "tests/support/no_alloc.hpp"

#include <gtest/gtest.h>

#include <cerrno>
#include <cstddef>

namespace shaker::test {
namespace {

thread_local constinit HeapCalls calls;

}  // namespace

HeapCalls heap_calls() noexcept { return calls; }

NoAlloc::~NoAlloc() {
    const HeapCalls after = calls;
    EXPECT_EQ(after.taken - before_.taken, 0U) << "memory was allocated while a NoAlloc guard watched";
    EXPECT_EQ(after.returned - before_.returned, 0U) << "memory was freed while a NoAlloc guard watched";
}

}  // namespace shaker::test

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)

// A sanitiser has replaced the heap; it reports each call to a hook.
using TakenHook = void (*)(const volatile void*, std::size_t);
using ReturnedHook = void (*)(const volatile void*);
extern "C" int install_heap_hooks(TakenHook,
                                  ReturnedHook) __asm__("__sanitizer_install_malloc_and_free_hooks");

namespace {
[[maybe_unused]] const int hooked = install_heap_hooks(
    [](const volatile void*, std::size_t) { ++shaker::test::calls.taken; },
    [](const volatile void* memory) { shaker::test::calls.returned += memory != nullptr; });
}  // namespace

#else

// Every heap call of the program, including operator new and libraries, ends in one of these functions. The C
// library allows a program to replace them.
extern "C" {

void* heap_malloc(std::size_t) __asm__("__libc_malloc");
void* heap_calloc(std::size_t, std::size_t) __asm__("__libc_calloc");
void* heap_realloc(void*, std::size_t) __asm__("__libc_realloc");
void* heap_memalign(std::size_t, std::size_t) __asm__("__libc_memalign");
void heap_free(void*) __asm__("__libc_free");

void* malloc(std::size_t size) {
    ++shaker::test::calls.taken;
    return heap_malloc(size);
}
void* calloc(std::size_t count, std::size_t size) {
    ++shaker::test::calls.taken;
    return heap_calloc(count, size);
}
void* realloc(void* memory, std::size_t size) {
    ++shaker::test::calls.taken;
    return heap_realloc(memory, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
    ++shaker::test::calls.taken;
    return heap_memalign(alignment, size);
}
void* memalign(std::size_t alignment, std::size_t size) {
    ++shaker::test::calls.taken;
    return heap_memalign(alignment, size);
}
int posix_memalign(void** memory, std::size_t alignment, std::size_t size) {
    ++shaker::test::calls.taken;
    void* found = heap_memalign(alignment, size);
    if (found == nullptr) return ENOMEM;
    *memory = found;
    return 0;
}
void free(void* memory) {
    shaker::test::calls.returned += memory != nullptr;
    heap_free(memory);
}

}  // extern "C"

#endif

#include "drivers/realtime.hpp"

#include <sched.h>
#include <sys/mman.h>
#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <ctime>

namespace shaker {
namespace {

constexpr std::size_t page = 4096;

std::string refusal(const std::string& what, int error, const std::string& remedy) {
    std::array<char, 128> words{};
    return what + ": " + strerror_r(error, words.data(), words.size()) + "; " + remedy;
}

/// Recursion reaches the next pages of the stack. The second write keeps the compiler from making it a
/// loop.
[[gnu::noinline]] void touch_pages(std::size_t count) noexcept {
    std::array<volatile std::byte, page> frame;
    frame[0] = std::byte{1};
    if (count > 1) touch_pages(count - 1);
    frame[page - 1] = std::byte{1};
}

/// Bytes of stack below this function's frame; 0 when unknown.
std::size_t stack_left() noexcept {
    pthread_attr_t attributes;
    if (pthread_getattr_np(pthread_self(), &attributes) != 0) return 0;
    void* lowest = nullptr;
    std::size_t size = 0;
    const int rc = pthread_attr_getstack(&attributes, &lowest, &size);
    pthread_attr_destroy(&attributes);
    const auto here = reinterpret_cast<std::uintptr_t>(__builtin_frame_address(0));
    const auto end = reinterpret_cast<std::uintptr_t>(lowest);
    return rc == 0 && here > end ? here - end : 0;
}

}  // namespace

std::string lock_memory() noexcept {
    const std::string what = "memory cannot be locked";
    const std::string remedy = "allow it with LimitMEMLOCK=infinity in the unit or 'ulimit -l unlimited'";
    rlimit limit{};
    if (getrlimit(RLIMIT_MEMLOCK, &limit) != 0) return refusal(what, errno, remedy);
    if (limit.rlim_cur != RLIM_INFINITY) {
        const rlimit unlimited{RLIM_INFINITY, RLIM_INFINITY};
        if (setrlimit(RLIMIT_MEMLOCK, &unlimited) != 0)
            return what + ": only " + std::to_string(limit.rlim_cur / 1024) + " kB may be locked; " + remedy;
    }
    return mlockall(MCL_CURRENT | MCL_FUTURE) == 0 ? std::string{} : refusal(what, errno, remedy);
}

std::string use_fifo_priority(int priority, pthread_t thread) noexcept {
    const std::string what = "cannot set real-time priority " + std::to_string(priority);
    if (priority < 1 || priority > 99) return what + ": must be 1 to 99";
    const sched_param parameters{.sched_priority = priority};
    const int error = pthread_setschedparam(thread, SCHED_FIFO, &parameters);
    return error == 0 ? std::string{}
                      : refusal(what, error, "allow it with LimitRTPRIO=99 in the unit or 'ulimit -r 99'");
}

void use_ordinary_priority(pthread_t thread) noexcept {
    const sched_param parameters{.sched_priority = 0};
    pthread_setschedparam(thread, SCHED_OTHER, &parameters);
}

double thread_time_s() noexcept {
    timespec t{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

std::string name_thread(const std::string& name) noexcept {
    const int error = pthread_setname_np(pthread_self(), name.c_str());
    return error == 0 ? std::string{}
                      : refusal("cannot name thread '" + name + "'", error, "at most 15 characters");
}

std::string prefault_stack(std::size_t bytes) noexcept {
    // An array of one page needs slightly more than a page of stack, and the caller needs some too.
    constexpr std::size_t frame = page + 256;
    constexpr std::size_t reserve = 16 * page;
    const std::size_t left = stack_left();
    if (left < reserve || bytes > (left - reserve) / frame * page)
        return "cannot prefault the stack: " + std::to_string(bytes) + " bytes requested, " +
               std::to_string(left) + " left; allow more with LimitSTACK in the unit or 'ulimit -s'";
    if (bytes > 0) touch_pages((bytes + page - 1) / page);
    return {};
}

}  // namespace shaker

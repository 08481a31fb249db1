#include "drivers/realtime.hpp"

#include <gtest/gtest.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/resource.h>

#include <array>
#include <fstream>
#include <functional>
#include <thread>

namespace shaker {
namespace {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool sanitised = true;
#else
constexpr bool sanitised = false;
#endif

void in_new_thread(const std::function<void()>& body) { std::thread{body}.join(); }

long locked_kb() {
    std::ifstream status{"/proc/self/status"};
    std::string word;
    while (status >> word)
        if (word == "VmLck:") {
            long kB = 0;
            status >> kB;
            return kB;
        }
    return -1;
}

TEST(RealtimeTest, LocksMemoryOrNamesTheRemedy) {
    if (sanitised)
        GTEST_SKIP() << "a sanitiser turns mlockall into nothing, for its memory is too large to lock";
    const std::string refused = lock_memory();
    const long kB = locked_kb();
    munlockall();
    if (refused.empty()) {
        EXPECT_GT(kB, 1000);
    } else {
        EXPECT_EQ(kB, 0) << refused;
        EXPECT_NE(refused.find("LimitMEMLOCK"), std::string::npos) << refused;
    }
}

TEST(RealtimeTest, SetsPriorityOrNamesTheRemedy) {
    in_new_thread([] {
        const std::string refused = use_fifo_priority(10);
        int policy = -1;
        sched_param parameters{};
        ASSERT_EQ(pthread_getschedparam(pthread_self(), &policy, &parameters), 0);
        if (refused.empty()) {
            EXPECT_EQ(policy, SCHED_FIFO);
            EXPECT_EQ(parameters.sched_priority, 10);
        } else {
            EXPECT_EQ(policy, SCHED_OTHER);
            EXPECT_NE(refused.find("LimitRTPRIO"), std::string::npos) << refused;
        }
    });
}

TEST(RealtimeTest, RefusesInvalidPriorities) {
    for (const int priority : {-1, 0, 100})
        EXPECT_NE(use_fifo_priority(priority).find("1 to 99"), std::string::npos);
}

TEST(RealtimeTest, NamesTheCallingThread) {
    in_new_thread([] {
        EXPECT_EQ(name_thread("fifteen letters"), "");
        std::array<char, 16> name{};
        ASSERT_EQ(pthread_getname_np(pthread_self(), name.data(), name.size()), 0);
        EXPECT_STREQ(name.data(), "fifteen letters");
        EXPECT_NE(name_thread("sixteen letters!").find("at most 15"), std::string::npos);
        ASSERT_EQ(pthread_getname_np(pthread_self(), name.data(), name.size()), 0);
        EXPECT_STREQ(name.data(), "fifteen letters");
    });
}

[[gnu::noinline]] void use_stack() {
    std::array<volatile char, 200000> local;
    for (std::size_t i = 0; i < local.size(); i += 1000) local[i] = 1;
}

long page_faults() {
    rusage usage{};
    getrusage(RUSAGE_THREAD, &usage);
    return usage.ru_minflt + usage.ru_majflt;
}

/// Page faults of use_stack() in a thread whose stack nobody has used before.
long faults_on_fresh_stack(bool prefault) {
    constexpr std::size_t size = 1 << 20;
    void* stack = mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    pthread_attr_t attributes;
    pthread_attr_init(&attributes);
    pthread_attr_setstack(&attributes, stack, size);
    struct Task {
        bool prefault;
        std::string refused;
        long faults;
    } task{prefault, "", -1};
    const auto body = [](void* argument) -> void* {
        auto& own = *static_cast<Task*>(argument);
        if (own.prefault) own.refused = prefault_stack(262144);
        const long before = page_faults();
        use_stack();
        own.faults = page_faults() - before;
        return nullptr;
    };
    pthread_t thread{};
    EXPECT_EQ(pthread_create(&thread, &attributes, body, &task), 0);
    pthread_join(thread, nullptr);
    pthread_attr_destroy(&attributes);
    munmap(stack, size);
    EXPECT_EQ(task.refused, "");
    return task.faults;
}

TEST(RealtimeTest, APrefaultedStackHasNoMissingPages) {
    if (sanitised)
        GTEST_SKIP() << "a sanitiser keeps shadow pages beside the stack, and those are missing at first";
    EXPECT_GT(faults_on_fresh_stack(false), 10);
    EXPECT_EQ(faults_on_fresh_stack(true), 0);
}

TEST(RealtimeTest, RefusesMoreStackThanAvailable) {
    in_new_thread([] {
        const std::string refused = prefault_stack(std::size_t{1} << 40);
        EXPECT_NE(refused.find("LimitSTACK"), std::string::npos) << refused;
    });
}

}  // namespace
}  // namespace shaker

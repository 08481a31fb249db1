#include "drivers/lent_priority.hpp"

#include <ctime>
#include <system_error>

#include "drivers/realtime.hpp"

namespace shaker {

namespace {

using std::chrono::nanoseconds;

// Processor time of a thread since its start.
nanoseconds used_by(clockid_t clock) noexcept {
    timespec used{};
    clock_gettime(clock, &used);
    return std::chrono::seconds{used.tv_sec} + nanoseconds{used.tv_nsec};
}

}  // namespace

LentPriority::LentPriority(pthread_t thread, int priority, double share)
    : thread_{thread}, priority_{priority}, share_{share}, refused_{use_fifo_priority(priority, thread)} {
    if (!refused_.empty()) return;
    try {
        watcher_ = std::jthread{[this](const std::stop_token& stop) { watch(stop); }};
    } catch (const std::system_error& error) {
        use_ordinary_priority(thread);
        refused_ = "cannot start the thread that bounds real-time priority " + std::to_string(priority) +
                   ": " + error.what();
    }
}

void LentPriority::watch(const std::stop_token& stop) const {
    clockid_t clock{};
    static_cast<void>(name_thread("share-" + std::to_string(priority_)));
    const bool watched =
        use_fifo_priority(priority_ + 1).empty() && pthread_getcpuclockid(thread_, &clock) == 0;
    if (!watched) return use_ordinary_priority(thread_);
    bool lent = true;
    for (nanoseconds before = used_by(clock); !stop.stop_requested();) {
        std::this_thread::sleep_for(window);
        const nanoseconds used = used_by(clock);
        const bool lend = used - before <= share_ * window;
        if (lent && !lend) use_ordinary_priority(thread_);
        if (lend && !lent) static_cast<void>(use_fifo_priority(priority_, thread_));
        lent = lend;
        before = used;
    }
}

}  // namespace shaker

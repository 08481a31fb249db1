#include "daemon/remote/lent_priority.hpp"

#include <sched.h>
#include <spdlog/fmt/fmt.h>

#include <cstring>
#include <ctime>

#include "drivers/realtime.hpp"

namespace shaker::remote {

namespace {

using std::chrono::nanoseconds;

int set_priority(pthread_t thread, int priority) noexcept {
    const sched_param parameters{.sched_priority = priority};
    return pthread_setschedparam(thread, priority > 0 ? SCHED_FIFO : SCHED_OTHER, &parameters);
}

// Processor time of a thread since its start.
nanoseconds used_by(clockid_t clock) noexcept {
    timespec used{};
    clock_gettime(clock, &used);
    return std::chrono::seconds{used.tv_sec} + nanoseconds{used.tv_nsec};
}

}  // namespace

LentPriority::LentPriority(pthread_t thread, int priority) : thread_{thread}, priority_{priority} {
    if (const int error = set_priority(thread, priority); error != 0) {
        refused_ = fmt::format(
            "remote: cannot set real-time priority {}: {}; an abort may wait for pictures. Allow it with "
            "LimitRTPRIO=99 in the unit or 'ulimit -r 99'",
            priority, std::strerror(error));
        return;
    }
    watcher_ = std::jthread{[this](const std::stop_token& stop) { watch(stop); }};
}

void LentPriority::watch(const std::stop_token& stop) const {
    clockid_t clock{};
    static_cast<void>(name_thread("remote-share"));
    const bool watched =
        use_fifo_priority(priority_ + 1).empty() && pthread_getcpuclockid(thread_, &clock) == 0;
    if (!watched) {
        set_priority(thread_, 0);
        return;
    }
    bool lent = true;
    for (nanoseconds before = used_by(clock); !stop.stop_requested();) {
        std::this_thread::sleep_for(window);
        const nanoseconds used = used_by(clock);
        const bool lend = used - before <= window / 2;
        if (lend != lent) set_priority(thread_, lend ? priority_ : 0);
        lent = lend;
        before = used;
    }
}

}  // namespace shaker::remote

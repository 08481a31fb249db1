#pragma once
// The clock of the server's deadlines: silent sessions, closed pages, unanswered orders, slow readers.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <boost/asio/basic_waitable_timer.hpp>

namespace shaker::access {

/// The steady clock, plus the time by which a test has advanced it. Thread safety: any thread.
class ServerClock {
public:
    using duration = std::chrono::steady_clock::duration;
    using rep = duration::rep;
    using period = duration::period;
    using time_point = std::chrono::time_point<ServerClock>;
    static constexpr bool is_steady = true;

    static time_point now() noexcept {
        return time_point{std::chrono::steady_clock::now().time_since_epoch() + duration{advanced_.load()}};
    }
    /// For tests. Timers expire at most ServerWait::longest later.
    static void advance(duration by) noexcept { advanced_ += by.count(); }

private:
    inline static std::atomic<rep> advanced_{0};
};

/// Limits the time for which a timer sleeps before it reads the clock again.
struct ServerWait {
    static constexpr ServerClock::duration longest = std::chrono::milliseconds{20};
    static ServerClock::duration to_wait_duration(const ServerClock::duration& d) noexcept {
        return std::min(d, longest);
    }
    static ServerClock::duration to_wait_duration(const ServerClock::time_point& t) noexcept {
        return to_wait_duration(t - ServerClock::now());
    }
};

using ServerTimer = boost::asio::basic_waitable_timer<ServerClock, ServerWait>;

}  // namespace shaker::access

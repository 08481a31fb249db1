#pragma once
// Messages to the service manager: ready, a line with the state, and watchdog signals while all threads are
// alive.
#include <chrono>
#include <cstdint>
#include <string>

#include "daemon/service/bench_state.hpp"
#include "daemon/service/heartbeats.hpp"

namespace shaker::service {

/// Does nothing without a service manager.
class SystemdNotify {
public:
    SystemdNotify();
    /// Longest time that the manager waits for the end of the daemon after the newest report of a live one.
    static constexpr std::chrono::seconds stop_patience{10};

    /// Call it often. While a heartbeat is overdue, no watchdog signal is sent, and the manager ends the
    /// program. leaving: the daemon is shutting down: it ramps the drive to zero and completes recordings.
    /// The manager then waits stop_patience longer, again and again, while no heartbeat is overdue.
    void report(const BenchState& state, Heartbeats& heartbeats, bool leaving);

private:
    void feed_watchdog(std::chrono::steady_clock::time_point now);

    std::chrono::steady_clock::duration every_{};  // between two watchdog signals; 0: no watchdog
    std::chrono::steady_clock::time_point signalled_{};
    std::chrono::steady_clock::time_point extended_{};
    const Heartbeat* late_ = nullptr;
    bool ready_ = false, stopping_ = false;
    std::string status_;
};

}  // namespace shaker::service

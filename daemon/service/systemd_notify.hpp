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
    /// Call it often. While a heartbeat is overdue, no watchdog signal is sent, and the manager ends the
    /// program. leaving: the daemon is shutting down and ramps the drive to zero.
    void report(const BenchState& state, Heartbeats& heartbeats, bool leaving);

private:
    std::chrono::steady_clock::duration every_{};  // between two watchdog signals; 0: no watchdog
    std::chrono::steady_clock::time_point signalled_{};
    const Heartbeat* late_ = nullptr;
    bool ready_ = false, stopping_ = false;
    std::string status_;
};

}  // namespace shaker::service

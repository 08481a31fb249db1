#pragma once
// Messages to the service manager: ready, a line with the state, and watchdog signals while the output loop
// runs.
#include <chrono>
#include <cstdint>
#include <string>

#include "daemon/service/bench_state.hpp"

namespace shaker::service {

/// Does nothing without a service manager.
class SystemdNotify {
public:
    SystemdNotify();
    /// Call it often. heartbeat: DAC sample up to which the played drive was gathered. While it does not
    /// change, no watchdog signal is sent, and the manager ends the program. leaving: the daemon is shutting
    /// down and ramps the drive to zero.
    void report(const BenchState& state, std::int64_t heartbeat, bool leaving);

private:
    std::chrono::steady_clock::duration every_{};  // between two watchdog signals; 0: no watchdog
    std::chrono::steady_clock::time_point signalled_{};
    std::int64_t heartbeat_ = -1;
    bool ready_ = false, stopping_ = false;
    std::string status_;
};

}  // namespace shaker::service

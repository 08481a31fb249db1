#pragma once
// What the service manager is told: ready, one line of state, a sign of life that only comes while the
// drive's loop lives.
#include <chrono>
#include <cstdint>
#include <string>

#include "daemon/bench_state.hpp"

namespace shaker {

/// Without a service manager everything here does nothing.
class ServiceNotes {
public:
    ServiceNotes();
    /// Often. heartbeat: counts what the output's loop has played; when it stands still, no sign of life is
    /// given and the manager ends the program.
    /// leaving: the daemon was asked to end and brings the drive down.
    void look(const BenchState& state, std::int64_t heartbeat, bool leaving);

private:
    std::chrono::steady_clock::duration every_{};  // between two signs of life; 0: none are asked for
    std::chrono::steady_clock::time_point told_{};
    std::int64_t heartbeat_ = -1;
    bool ready_ = false, stopping_ = false;
    std::string status_;
};

}  // namespace shaker

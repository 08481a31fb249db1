#pragma once
// What Prometheus reads at /metrics.
#include <cstdint>
#include <string>

#include "daemon/bench_state.hpp"

namespace shaker::web {

/// What the daemon's remote side has counted of itself.
struct ServedCounts {
    std::uint64_t requests = 0, refused_requests = 0, messages_dropped = 0;
    std::uint64_t scpi_commands = 0, scpi_errors = 0;
    int web_clients = 0, scpi_clients = 0;
};

/// Text format 0.0.4: base units, counters end in _total. state: null before the bench has told of itself.
std::string metrics_text(const BenchState* state, const ServedCounts& served);

}  // namespace shaker::web

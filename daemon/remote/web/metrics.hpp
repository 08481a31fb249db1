#pragma once
// Metrics for Prometheus at /metrics.
#include <cstdint>
#include <string>

#include "daemon/service/bench_state.hpp"

namespace shaker::web {

/// Counters of the daemon's remote side.
struct ServedCounts {
    std::uint64_t requests = 0, refused_requests = 0, messages_dropped = 0;
    std::uint64_t scpi_commands = 0, scpi_errors = 0;
    std::uint64_t troubles = 0;  // exceptions in the server's own code
    int web_clients = 0, scpi_clients = 0;
};

/// prometheus: text format 0.0.4. open: OpenMetrics 1.0, for a client whose Accept names it.
enum class MetricsFormat : std::uint8_t { prometheus, open };

/// Base units, counters end in _total. state: null before the first state of the bench.
std::string metrics_text(const service::BenchState* state, const ServedCounts& served,
                         MetricsFormat format = MetricsFormat::prometheus);

}  // namespace shaker::web

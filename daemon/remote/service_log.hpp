#pragma once
// The log of the daemon: written by a thread of its own, never waited for, at a bounded rate, with nothing in
// it that a terminal or the journal would obey.
#include <spdlog/sinks/sink.h>

#include <memory>

namespace shaker {

struct LogRate {
    int burst = 100;    // messages at once
    double per_s = 10;  // that are earned again
};

/// Passes messages on to `inner` with control characters as \xNN, and no more than `rate`; how many were left
/// out is said with the next that passes. Errors always pass.
std::shared_ptr<spdlog::sinks::sink> bounded_sink(std::shared_ptr<spdlog::sinks::sink> inner, LogRate rate);

/// While it lives spdlog's default logger is asynchronous: to the journal when systemd started this process,
/// else to the standard error. A full queue drops its oldest message.
class ServiceLog {
public:
    ServiceLog();
    ServiceLog(const ServiceLog&) = delete;
    ServiceLog& operator=(const ServiceLog&) = delete;
    /// All that waits is written.
    ~ServiceLog();
};

}  // namespace shaker

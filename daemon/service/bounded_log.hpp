#pragma once
// The log of the daemon. A separate thread writes it at a bounded rate, so callers never wait. Control
// characters are written as text, see drivers/text/printable.hpp.
#include <spdlog/sinks/sink.h>

#include <memory>

namespace shaker::service {

struct LogRate {
    int burst = 100;    // messages that may come at once
    double per_s = 10;  // messages per second beyond the burst
};

/// Passes messages to `inner`, at most at `rate`, with control characters as text. The next message that
/// passes reports how many were left out. Errors always pass.
std::shared_ptr<spdlog::sinks::sink> bounded_sink(std::shared_ptr<spdlog::sinks::sink> inner, LogRate rate);

class StandardError;

/// While it exists, spdlog's default logger is asynchronous. It writes to the journal if systemd started this
/// process, otherwise to standard error. A full queue drops its oldest message.
class BoundedLog {
public:
    BoundedLog();
    BoundedLog(const BoundedLog&) = delete;
    BoundedLog& operator=(const BoundedLog&) = delete;
    /// Writes all messages in the queue. When nobody reads standard error, those that it does not take within
    /// a second are lost.
    ~BoundedLog();

private:
    std::shared_ptr<StandardError> standard_error_;  // null: the journal
};

}  // namespace shaker::service

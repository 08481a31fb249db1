#pragma once
// A server with wrong answers, for tests of clients of the daemon.
#include <string>
#include <thread>

namespace shaker::test {

/// Accepts each connection on a local port, reads the header of a request, sends fixed bytes and closes.
/// Without bytes it sends nothing and keeps the connection open.
class CannedDaemon {
public:
    explicit CannedDaemon(std::string bytes);
    ~CannedDaemon();
    CannedDaemon(const CannedDaemon&) = delete;
    CannedDaemon& operator=(const CannedDaemon&) = delete;

    [[nodiscard]] int port() const noexcept { return port_; }

private:
    void serve(const std::stop_token& stop) const;

    std::string bytes_;
    int door_ = -1, port_ = 0;
    std::jthread thread_;
};

/// A complete HTTP response.
std::string http_answer(const std::string& status, const std::string& body);

}  // namespace shaker::test

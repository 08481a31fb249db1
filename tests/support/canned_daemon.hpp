#pragma once
// What a daemon should never be: for tests of its clients.
#include <string>
#include <thread>

namespace shaker::test {

/// Takes each connection on a port of this machine, reads a request's header, sends the same bytes back and
/// closes; with no bytes it keeps silent and the connection open.
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

/// A whole answer over HTTP.
std::string http_answer(const std::string& status, const std::string& body);

}  // namespace shaker::test

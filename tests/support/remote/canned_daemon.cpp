#include "tests/support/remote/canned_daemon.hpp"

#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <system_error>
#include <vector>

namespace shaker::test {

namespace {

constexpr int look_ms = 10;

bool readable(int socket) {
    pollfd ready{.fd = socket, .events = POLLIN, .revents = 0};
    return ::poll(&ready, 1, look_ms) == 1;
}

}  // namespace

CannedDaemon::CannedDaemon(std::string bytes) : bytes_{std::move(bytes)} {
    door_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in at{};
    at.sin_family = AF_INET;
    at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof at;
    auto* const address = reinterpret_cast<sockaddr*>(&at);
    if (::bind(door_, address, size) != 0 || ::listen(door_, 8) != 0 ||
        ::getsockname(door_, address, &size) != 0)
        throw std::system_error{errno, std::system_category(), "a port of this machine"};
    port_ = ntohs(at.sin_port);
    thread_ = std::jthread{[this](const std::stop_token& stop) { serve(stop); }};
}

CannedDaemon::~CannedDaemon() {
    thread_.request_stop();
    thread_.join();
    ::close(door_);
}

void CannedDaemon::serve(const std::stop_token& stop) const {
    std::vector<int> held;
    while (!stop.stop_requested()) {
        if (!readable(door_)) continue;
        const int client = ::accept4(door_, nullptr, nullptr, SOCK_CLOEXEC);
        if (bytes_.empty()) {
            held.push_back(client);
            continue;
        }
        std::string request;
        std::array<char, 4096> part{};
        while (request.find("\r\n\r\n") == std::string::npos && !stop.stop_requested()) {
            if (!readable(client)) continue;
            const ssize_t n = ::recv(client, part.data(), part.size(), 0);
            if (n <= 0) break;
            request.append(part.data(), static_cast<std::size_t>(n));
        }
        for (std::size_t sent = 0; sent < bytes_.size();) {
            const ssize_t n = ::send(client, bytes_.data() + sent, bytes_.size() - sent, MSG_NOSIGNAL);
            if (n <= 0) break;
            sent += static_cast<std::size_t>(n);
        }
        ::shutdown(client, SHUT_WR);
        held.push_back(client);
    }
    for (const int client : held) ::close(client);
}

std::string http_answer(const std::string& status, const std::string& body) {
    return "HTTP/1.1 " + status +
           "\r\nContent-Type: application/json\r\nContent-Length: " + std::to_string(body.size()) +
           "\r\n\r\n" + body;
}

}  // namespace shaker::test

#include "tests/support/remote/tcp_client.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <stdexcept>
#include <utility>

namespace shaker::test {

namespace {
constexpr int patience_ms = 5000;
}

TcpClient::TcpClient(int port) : socket_{::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)} {
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(static_cast<std::uint16_t>(port));
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (::connect(socket_, reinterpret_cast<const sockaddr*>(&to), sizeof to) != 0)
        throw std::runtime_error{"no connection to port " + std::to_string(port)};
}

TcpClient::TcpClient(const std::filesystem::path& socket)
    : socket_{::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0)} {
    sockaddr_un to{};
    to.sun_family = AF_UNIX;
    socket.string().copy(to.sun_path, sizeof to.sun_path - 1);
    if (::connect(socket_, reinterpret_cast<const sockaddr*>(&to), sizeof to) != 0)
        throw std::runtime_error{"no connection to " + socket.string()};
}

TcpClient::~TcpClient() { ::close(socket_); }

void TcpClient::send(std::string_view line) { send_bytes(std::string{line} + "\n"); }

void TcpClient::send_bytes(std::string_view bytes) {
    while (!bytes.empty()) {
        const ssize_t n = ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
        if (n <= 0) return;
        bytes.remove_prefix(static_cast<std::size_t>(n));
    }
}

void TcpClient::send_no_more() { ::shutdown(socket_, SHUT_WR); }

bool TcpClient::more() {
    pollfd ready{.fd = socket_, .events = POLLIN, .revents = 0};
    if (::poll(&ready, 1, patience_ms) <= 0) return false;
    std::array<char, 65536> bytes{};
    const ssize_t n = ::recv(socket_, bytes.data(), bytes.size(), 0);
    if (n <= 0) return false;
    buffer_.append(bytes.data(), static_cast<std::size_t>(n));
    return true;
}

std::string TcpClient::bytes(std::size_t n) {
    while (buffer_.size() < n && more()) {
    }
    std::string got = buffer_.substr(0, n);
    buffer_.erase(0, n);
    return got;
}

std::string TcpClient::until(std::string_view end) {
    std::size_t at = buffer_.find(end);
    while (at == std::string::npos && more()) at = buffer_.find(end);
    const std::size_t size = at == std::string::npos ? buffer_.size() : at + end.size();
    std::string got = buffer_.substr(0, size);
    buffer_.erase(0, size);
    return got;
}

std::string TcpClient::some() {
    if (buffer_.empty()) static_cast<void>(more());
    return std::exchange(buffer_, {});
}

std::string TcpClient::line() {
    std::string got = until("\n");
    if (!got.empty() && got.back() == '\n') got.pop_back();
    return got;
}

std::string TcpClient::block() {
    while (buffer_.size() < 2 && more()) {
    }
    if (buffer_.size() < 2 || buffer_[0] != '#') return {};
    const auto digits = static_cast<std::size_t>(buffer_[1] - '0');
    while (buffer_.size() < 2 + digits && more()) {
    }
    const std::size_t size = std::stoul(buffer_.substr(2, digits));
    while (buffer_.size() < 2 + digits + size + 1 && more()) {
    }
    std::string data = buffer_.substr(2 + digits, size);
    buffer_.erase(0, 2 + digits + size + 1);
    return data;
}

std::string TcpClient::rest() {
    while (more()) {
    }
    return std::move(buffer_);
}

bool TcpClient::closed(int within_ms) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds{within_ms};
    std::array<char, 65536> bytes{};
    for (;;) {
        const auto left = end - std::chrono::steady_clock::now();
        const auto left_ms = std::chrono::duration_cast<std::chrono::milliseconds>(left).count();
        pollfd ready{.fd = socket_, .events = POLLIN, .revents = 0};
        if (::poll(&ready, 1, static_cast<int>(std::max<long>(0, left_ms))) <= 0) return false;
        if (::recv(socket_, bytes.data(), bytes.size(), 0) <= 0) return true;
    }
}

}  // namespace shaker::test

#pragma once
// The daemon's remote side: HTTP with live streams, and the instrument language, on a thread of its own.
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "daemon/service/bench_port.hpp"

namespace shaker::remote {

struct ServerSettings {
    std::string address = "127.0.0.1";  // to listen on
    int http_port = 8080;               // 0: any that is free
    int scpi_port = 5025;
    std::vector<std::string> hosts{};           // names it answers to, beside its address and localhost
    std::string token{};                        // asked of HTTP clients; empty: none is
    std::filesystem::path page{};               // folder of the page's files; empty: there is no page
    std::chrono::milliseconds silence{60'000};  // of a session that gives way when all are taken
};

class Server {
public:
    /// Listens. DeviceError naming address and port when that is not possible. The desk outlives this.
    Server(service::BenchPort& bench_port, const ServerSettings& settings);
    /// Ends all connections.
    ~Server();
    Server(const Server&) = delete;
    Server& operator=(const Server&) = delete;

    /// Token, names and page of other settings, from now on. Any thread; the address stays.
    void adopt(const ServerSettings& settings);
    [[nodiscard]] int http_port() const noexcept;
    [[nodiscard]] int scpi_port() const noexcept;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace shaker::remote

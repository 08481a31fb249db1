#pragma once
// The daemon's remote control in a separate thread: HTTP with live streams, and the instrument language.
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "daemon/service/bench_port.hpp"

namespace shaker::remote {

struct ServerSettings {
    std::string address = "127.0.0.1";          // on which it listens
    int http_port = 8080;                       // 0: any free port
    int scpi_port = 5025;                       // 0: any free port
    std::vector<std::string> hosts{};           // host names of the daemon, besides its address and localhost
    std::string token{};                        // required from HTTP clients; empty: no token
    std::filesystem::path page{};               // folder of the page's files; empty: no page
    std::chrono::milliseconds silence{60'000};  // of a SCPI session that may be closed for a new one
};

class Server {
public:
    /// Starts to listen. DeviceError naming address and port when that fails. The port must outlive this
    /// object.
    Server(service::BenchPort& bench_port, const ServerSettings& settings);
    /// Ends all connections.
    ~Server();
    Server(const Server&) = delete;
    Server& operator=(const Server&) = delete;

    /// Takes token, host names and page from new settings. The address stays. Any thread.
    void adopt(const ServerSettings& settings);
    [[nodiscard]] int http_port() const noexcept;
    [[nodiscard]] int scpi_port() const noexcept;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace shaker::remote

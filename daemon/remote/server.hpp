#pragma once
// The daemon's remote control in a separate thread: HTTP with live streams, and the instrument language.
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "daemon/catalogue/catalogue.hpp"
#include "daemon/service/bench_port.hpp"

namespace shaker::remote {

struct ServerSettings {
    std::string address = "127.0.0.1";    // on which it listens
    int http_port = 8080;                 // 0: any free port
    int scpi_port = 5025;                 // 0: any free port
    std::filesystem::path scpi_socket{};  // Unix socket for scripts on this computer; empty: none
    std::vector<std::string> hosts{};     // host names of the daemon, besides its address and localhost
    std::string token{};                  // required from clients of both ports; empty: no token
    std::filesystem::path page{};         // folder of the page's files; empty: the program's own
    int fifo_priority = 0;                // SCHED_FIFO priority of its thread, see LentPriority; 0: ordinary
    std::chrono::milliseconds silence{60'000};  // of a SCPI session that may be closed for a new one
};

class Server {
public:
    /// Age of the newest beat of the server's thread up to which it is alive; it beats every 100 ms.
    static constexpr std::chrono::milliseconds longest_pause{500};

    /// Starts to listen. DeviceError naming address and port, or the socket, when that fails. InputError for
    /// an address that other machines can reach without a token. The port must outlive this object.
    /// recordings: for the list of recordings; null: none is served. It must outlive this object.
    Server(service::BenchPort& bench_port, const ServerSettings& settings,
           catalogue::Catalogue* recordings = nullptr);
    /// Ends all connections.
    ~Server();
    Server(const Server&) = delete;
    Server& operator=(const Server&) = delete;

    /// Takes token, host names and page from new settings. The address stays. Any thread.
    void adopt(const ServerSettings& settings);
    /// False when the thread that serves the clients has not turned for longest_pause: then no abort arrives
    /// over a network. For the watchdog. Any thread, never waits.
    [[nodiscard]] bool alive() const noexcept;
    /// Loads what clients may need later: nothing is loaded while a run is under way, and an upgrade of the
    /// program does not change a running one. Throws DeviceError.
    static void load_all();
    /// The operating system's refusal of the priority; empty: granted, or none was requested.
    [[nodiscard]] std::string refused() const;
    [[nodiscard]] int http_port() const noexcept;
    [[nodiscard]] int scpi_port() const noexcept;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace shaker::remote

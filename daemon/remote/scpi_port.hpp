#pragma once
// The instrument language over TCP: one session per connection.
#include <chrono>
#include <cstdint>
#include <list>
#include <memory>
#include <string>
#include <utility>

#include "daemon/remote/access/server_clock.hpp"
#include "daemon/remote/instrument/commands.hpp"
#include "daemon/remote/scpi/session.hpp"

#include <boost/asio/awaitable.hpp>
#include <boost/asio/ip/tcp.hpp>

namespace shaker::remote {

class ScpiPort {
public:
    static constexpr std::size_t most_sessions = 16;

    /// silence: time after which a silent session that neither holds control nor waits may be closed. It is
    /// closed when a new client connects and most_sessions are open.
    ScpiPort(service::PendingOrders& pending_orders, access::ControlLock& lock,
             std::chrono::milliseconds silence);

    /// Serves a connection until it closes. Never throws.
    boost::asio::awaitable<void> serve(boost::asio::ip::tcp::socket socket);
    /// Call it often. Sets the status registers from the state, reports trips to all sessions, and continues
    /// waiting commands.
    void update();
    /// Sets the answer of STReam:ADDRess?. Call it before any client is served.
    void set_streams(std::string address) { instrument_.streams = std::move(address); }
    [[nodiscard]] int sessions() const noexcept { return static_cast<int>(clients_.size()); }
    [[nodiscard]] std::uint64_t messages() const noexcept { return messages_; }
    /// Number of errors reported to clients.
    [[nodiscard]] std::uint64_t errors() const noexcept { return errors_; }
    [[nodiscard]] const scpi::CommandTree& tree() const noexcept { return tree_; }

private:
    struct Client {
        Client(scpi::Shared shared, std::string name, boost::asio::ip::tcp::socket s)
            : session{shared, std::move(name)}, socket{std::move(s)} {}
        scpi::Session session;
        boost::asio::ip::tcp::socket socket;
        access::ServerTimer goodbye{socket.get_executor()};
        access::ServerClock::time_point heard = access::ServerClock::now();
        bool sending = false;
        std::uint64_t counted = 0;  // errors of the session that are in errors_
    };
    bool make_room();
    void count_errors(Client& client) noexcept;
    boost::asio::awaitable<void> converse(std::shared_ptr<Client> client);
    static void begin_flush(const std::shared_ptr<Client>& client);
    static boost::asio::awaitable<void> flush(std::shared_ptr<Client> client);

    scpi::DeviceStatus status_;
    access::ControlLock& lock_;
    std::chrono::milliseconds silence_;
    instrument::BenchInstrument instrument_;
    scpi::CommandTree tree_;
    std::list<std::shared_ptr<Client>> clients_;
    std::uint64_t messages_ = 0, errors_ = 0, trips_ = 0;
};

}  // namespace shaker::remote

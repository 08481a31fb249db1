#pragma once
// The instrument language over TCP: one session a connection.
#include <chrono>
#include <cstdint>
#include <list>
#include <memory>
#include <string>
#include <utility>

#include "daemon/remote/instrument/commands.hpp"
#include "daemon/remote/scpi/session.hpp"

#include <boost/asio/awaitable.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>

namespace shaker::remote {

class ScpiPort {
public:
    static constexpr std::size_t most_sessions = 16;

    /// silence: a session that said nothing for so long, holds no control and waits for nothing gives way to
    /// a new one when there are as many as there may be.
    ScpiPort(service::PendingOrders& pending_orders, access::ControlLock& lock,
             std::chrono::milliseconds silence);

    /// Serves a connection to its end. Never throws.
    boost::asio::awaitable<void> serve(boost::asio::ip::tcp::socket socket);
    /// Often: shows the state in the status registers, tells of a trip, goes on with what waits.
    void look();
    /// What STReam:ADDRess? answers. Before anybody is served.
    void tell_streams(std::string address) { instrument_.streams = std::move(address); }
    [[nodiscard]] int sessions() const noexcept { return static_cast<int>(clients_.size()); }
    [[nodiscard]] std::uint64_t messages() const noexcept { return messages_; }
    /// Errors that its clients were told of.
    [[nodiscard]] std::uint64_t errors() const noexcept { return errors_; }
    [[nodiscard]] const scpi::CommandTree& tree() const noexcept { return tree_; }

private:
    struct Client {
        Client(scpi::Shared shared, std::string name, boost::asio::ip::tcp::socket s)
            : session{shared, std::move(name)}, socket{std::move(s)} {}
        scpi::Session session;
        boost::asio::ip::tcp::socket socket;
        boost::asio::steady_timer goodbye{socket.get_executor()};
        std::chrono::steady_clock::time_point heard = std::chrono::steady_clock::now();
        bool sending = false;
        std::uint64_t counted = 0;  // of its errors
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

#pragma once
// The instrument language over TCP and a Unix socket: one session per connection.
#include <chrono>
#include <cstdint>
#include <list>
#include <memory>
#include <string>
#include <utility>

#include "daemon/remote/access/access.hpp"
#include "daemon/remote/access/server_clock.hpp"
#include "daemon/remote/instrument/instrument.hpp"
#include "daemon/remote/scpi/session.hpp"

#include <boost/asio/awaitable.hpp>
#include <boost/asio/generic/stream_protocol.hpp>

namespace shaker::remote {

class ScpiPort {
public:
    using Socket = boost::asio::generic::stream_protocol::socket;
    static constexpr std::size_t most_sessions = 16;
    /// Connections beyond most_sessions that have not sent their first message.
    static constexpr std::size_t most_late = 64;

    /// The objects that the port uses; they must outlive it.
    struct Parts {
        service::PendingOrders& pending_orders;
        access::ControlLock& lock;
        access::Aborts& aborts;
        const access::Access& access;
    };
    /// silence: time after which a silent session that neither holds control nor waits may be closed. It is
    /// closed when a new client connects and most_sessions are open.
    ScpiPort(const Parts& parts, std::chrono::milliseconds silence);

    /// Serves a connection until it closes. name: unique. When no session is free, only ABORt is obeyed, in
    /// the first message; then the connection is closed with an error. Never throws.
    boost::asio::awaitable<void> serve(Socket socket, std::string name, scpi::Admission admission);
    /// Call it often. Sets the status registers from the state, reports trips to all sessions, and continues
    /// waiting commands.
    void update();
    /// Call it after each abort: drops what waits to be ordered by other clients.
    void drop_waiting(const std::string& aborted_by);
    /// Sets the answer of STReam:ADDRess?. Call it before any client is served.
    void set_streams(std::string address) { instrument_.streams = std::move(address); }
    [[nodiscard]] int sessions() const noexcept { return static_cast<int>(clients_.size()); }
    [[nodiscard]] std::uint64_t messages() const noexcept { return messages_; }
    /// Number of errors reported to clients.
    [[nodiscard]] std::uint64_t errors() const noexcept { return errors_; }
    [[nodiscard]] const scpi::CommandTree& tree() const noexcept { return tree_; }

private:
    struct Client {
        Client(scpi::Shared shared, std::string name, scpi::Admission admission, Socket s)
            : session{shared, std::move(name), admission}, socket{std::move(s)} {}
        scpi::Session session;
        Socket socket;
        access::ServerTimer goodbye{socket.get_executor()};
        access::ServerClock::time_point heard = access::ServerClock::now();
        bool sending = false;
        std::uint64_t counted = 0;  // errors of the session that are in errors_
    };
    using ClientPtr = std::shared_ptr<Client>;

    bool make_room();
    void count_errors(Client& client) noexcept;
    void hear(Client& client, std::string_view bytes);
    boost::asio::awaitable<void> converse(ClientPtr client);
    boost::asio::awaitable<void> hear_first_message(ClientPtr client);
    void send_away_longest();
    static void begin_flush(const ClientPtr& client);
    static boost::asio::awaitable<void> flush(ClientPtr client);

    scpi::DeviceStatus status_;
    Parts parts_;
    std::chrono::milliseconds silence_;
    instrument::BenchInstrument instrument_;
    scpi::CommandTree tree_;
    std::list<ClientPtr> clients_;
    std::list<ClientPtr> late_;  // found no session free; the longest waiting first
    std::uint64_t messages_ = 0, errors_ = 0, trips_ = 0;
};

}  // namespace shaker::remote

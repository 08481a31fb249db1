#include "daemon/remote/server.hpp"

#include <netinet/tcp.h>
#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>

#include <chrono>
#include <functional>
#include <mutex>
#include <thread>
#include <utility>

#include "daemon/remote/access/server_clock.hpp"
#include "daemon/remote/scpi_port.hpp"
#include "daemon/remote/web/web_client.hpp"
#include "drivers/errors.hpp"
#include "drivers/realtime.hpp"

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/use_awaitable.hpp>

namespace shaker::remote {

namespace asio = boost::asio;
using asio::use_awaitable;
using asio::ip::tcp;

namespace {

constexpr std::chrono::milliseconds update_every{5};
constexpr std::chrono::seconds lease{10};  // a page keeps control for this time after its last socket closed

tcp::acceptor listen_at(asio::io_context& io, const std::string& address, int port) {
    try {
        tcp::acceptor acceptor{io, {asio::ip::make_address(address), static_cast<unsigned short>(port)}};
        return acceptor;
    } catch (const boost::system::system_error& e) {
        throw DeviceError{fmt::format("{} port {}: {}", address, port, e.code().message())};
    }
}

// A connection to a dead machine or network is closed after two minutes, also when nothing is sent.
void watch_over(tcp::socket& socket) {
    using namespace boost::asio::detail::socket_option;
    boost::system::error_code ignored;
    socket.set_option(tcp::no_delay{true}, ignored);
    socket.set_option(asio::socket_base::keep_alive{true}, ignored);
    socket.set_option(integer<IPPROTO_TCP, TCP_KEEPIDLE>{60}, ignored);
    socket.set_option(integer<IPPROTO_TCP, TCP_KEEPINTVL>{10}, ignored);
    socket.set_option(integer<IPPROTO_TCP, TCP_KEEPCNT>{6}, ignored);
    socket.set_option(integer<IPPROTO_TCP, TCP_USER_TIMEOUT>{120'000}, ignored);  // ms
}

access::Access access_of(const ServerSettings& s) {
    access::Access access{.hosts = s.hosts, .token = s.token};
    for (const char* own : {"localhost", "127.0.0.1", "[::1]"}) access.hosts.emplace_back(own);
    access.hosts.push_back(s.address);
    return access;
}

/// Passes functions from the bench's thread to the server's; drops them when the server has ended.
class Letterbox {
public:
    explicit Letterbox(asio::io_context& io) : io_{&io} {}
    void post(std::function<void()> what) {
        const std::scoped_lock lock{mutex_};
        if (io_ != nullptr) asio::post(*io_, std::move(what));
    }
    void close() {
        const std::scoped_lock lock{mutex_};
        io_ = nullptr;
    }

private:
    std::mutex mutex_;
    asio::io_context* io_;
};

}  // namespace

struct Server::State {
    access::ControlLock lock;  // before `io`: connections in `io` use it until they are destroyed
    asio::io_context io{1};
    std::shared_ptr<Letterbox> letterbox = std::make_shared<Letterbox>(io);
    service::PendingOrders pending_orders;
    ScpiPort scpi;
    std::shared_ptr<web::Site> site;
    tcp::acceptor web_door, scpi_door;
    access::ServerClock::time_point held_at = access::ServerClock::now();
    std::jthread thread;

    State(service::BenchPort& bench_port, const ServerSettings& s)
        : pending_orders{bench_port,
                         [box = letterbox](std::function<void()> later) { box->post(std::move(later)); }},
          scpi{pending_orders, lock, s.silence},
          site{std::make_shared<web::Site>(web::Site{pending_orders, lock, web::Actions{pending_orders, lock},
                                                     access_of(s), web::read_page(s.page)})},
          web_door{listen_at(io, s.address, s.http_port)},
          scpi_door{listen_at(io, s.address, s.scpi_port)} {}

    template <class Serve>
    asio::awaitable<void> accept(tcp::acceptor& door, Serve serve) {
        for (;;) {
            boost::system::error_code failed;
            tcp::socket socket = co_await door.async_accept(asio::redirect_error(use_awaitable, failed));
            if (failed == asio::error::operation_aborted) co_return;
            if (failed) {  // no free descriptor, or the client has disconnected already
                access::ServerTimer pause{io, update_every};
                co_await pause.async_wait(use_awaitable);
                continue;
            }
            watch_over(socket);
            asio::co_spawn(io, serve(std::move(socket)), asio::detached);
        }
    }

    asio::awaitable<void> housekeeping() {
        access::ServerTimer timer{io};
        for (;;) {
            timer.expires_after(update_every);
            co_await timer.async_wait(use_awaitable);
            scpi.update();
            site->served.scpi_clients = scpi.sessions();
            site->served.scpi_commands = scpi.messages();
            site->served.scpi_errors = scpi.errors();
            end_stale_control();
        }
    }

    // A closed page loses control after the lease.
    void end_stale_control() {
        const std::string& owner = lock.owner();
        const auto now = access::ServerClock::now();
        if (!owner.starts_with("page") || site->sockets.contains(owner))
            held_at = now;
        else if (now - held_at > lease)
            lock.release(std::string{owner});
    }
};

Server::Server(service::BenchPort& bench_port, const ServerSettings& settings)
    : state_{std::make_unique<State>(bench_port, settings)} {
    State& s = *state_;
    s.scpi.set_streams(fmt::format("ws://{}:{}/ws", settings.address, http_port()));
    asio::co_spawn(
        s.io,
        s.accept(s.web_door, [&s](tcp::socket socket) { return web::serve(std::move(socket), s.site); }),
        asio::detached);
    asio::co_spawn(
        s.io, s.accept(s.scpi_door, [&s](tcp::socket socket) { return s.scpi.serve(std::move(socket)); }),
        asio::detached);
    asio::co_spawn(s.io, s.housekeeping(), asio::detached);
    s.thread = std::jthread{[&s] {
        static_cast<void>(name_thread("remote"));
        s.io.run();
    }};
}

Server::~Server() {
    state_->io.stop();
    if (state_->thread.joinable()) state_->thread.join();
    state_->letterbox->close();
}

void Server::adopt(const ServerSettings& settings) {
    asio::post(state_->io, [this, settings] {
        state_->site->access = access_of(settings);
        state_->site->page = web::read_page(settings.page);
    });
}

int Server::http_port() const noexcept { return state_->web_door.local_endpoint().port(); }
int Server::scpi_port() const noexcept { return state_->scpi_door.local_endpoint().port(); }

}  // namespace shaker::remote

#include "daemon/remote/server.hpp"

#include <spdlog/fmt/fmt.h>

#include <atomic>
#include <exception>
#include <functional>
#include <mutex>
#include <optional>
#include <string_view>
#include <thread>
#include <utility>

#include "daemon/remote/access/server_clock.hpp"
#include "daemon/remote/doors.hpp"
#include "daemon/remote/scpi_port.hpp"
#include "daemon/remote/web/live_frames.hpp"
#include "daemon/remote/web/page_files.hpp"
#include "daemon/remote/web/web_client.hpp"
#include "drivers/errors.hpp"
#include "drivers/lent_priority.hpp"
#include "drivers/realtime.hpp"

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>

namespace shaker::remote {

namespace asio = boost::asio;
using asio::use_awaitable;
using asio::ip::tcp;

namespace {

// A sign of life of one thread for others. Thread safety: one thread beats, any thread reads.
class Heartbeat {
    using Clock = std::chrono::steady_clock;

public:
    void beat() noexcept { newest_ = Clock::now().time_since_epoch().count(); }
    /// Time since the newest beat, or since the start.
    [[nodiscard]] std::chrono::nanoseconds age() const noexcept {
        return Clock::now().time_since_epoch() - Clock::duration{newest_.load()};
    }

private:
    std::atomic<Clock::rep> newest_{Clock::now().time_since_epoch().count()};
};

std::string words_of(const std::exception_ptr& exception) {
    try {
        std::rethrow_exception(exception);
    } catch (const std::exception& e) {
        return e.what();
    } catch (...) {
        return "unknown exception";
    }
}

// Exceptions that reached the end of a task of the server's thread. The task ended or begins again; the
// thread goes on. Used on the server's thread.
class Troubles {
public:
    explicit Troubles(service::BenchPort& bench_port) : bench_port_{bench_port} {}
    /// Counts the exception and writes it to the log. where: the task, "accepting of SCPI connections".
    void note(std::string_view where, const std::exception_ptr& exception) noexcept;
    [[nodiscard]] std::uint64_t count() const noexcept { return count_; }

private:
    service::BenchPort& bench_port_;
    std::uint64_t count_ = 0;
};

void Troubles::note(std::string_view where, const std::exception_ptr& exception) noexcept {
    ++count_;
    try {
        const auto now = bench_port_.state();
        bench_port_.log(
            now ? now->now_s : 0, "warning",
            fmt::format("internal error in the remote control, {}: {}", where, words_of(exception)));
    } catch (...) {  // no memory left: the count remains
    }
}

constexpr std::chrono::milliseconds update_every{5}, beat_every{100};
constexpr std::chrono::seconds lease{10};  // a page keeps control for this time after its last socket closed

void require_token(const ServerSettings& s) {
    boost::system::error_code not_an_address;
    const auto address = asio::ip::make_address(s.address, not_an_address);
    if (!s.token.empty() || not_an_address || address.is_loopback()) return;
    throw InputError{fmt::format(
        "address \"{}\" is reached from other machines, over HTTP and SCPI; token_file is required",
        s.address)};
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
    access::Aborts aborts;
    Troubles troubles;
    asio::io_context io{1};
    std::shared_ptr<Letterbox> letterbox = std::make_shared<Letterbox>(io);
    service::PendingOrders pending_orders;
    std::shared_ptr<web::Site> site;
    ScpiPort scpi;
    tcp::acceptor web_door, scpi_door;
    std::optional<LocalDoor> local_door;
    Heartbeat heartbeat;
    access::ServerClock::time_point held_at = access::ServerClock::now();
    std::jthread thread;
    std::optional<LentPriority> priority;

    State(service::BenchPort& bench_port, const ServerSettings& s)
        : aborts{{.stop = [&bench_port](const std::string& by) { return bench_port.abort(by); },
                  .obeyed = [&bench_port] { return bench_port.obeyed(); }}},
          troubles{bench_port},
          pending_orders{bench_port,
                         [box = letterbox](std::function<void()> later) { box->post(std::move(later)); }},
          site{std::make_shared<web::Site>(web::Site{pending_orders, lock,
                                                     web::Actions{pending_orders, lock, aborts}, access_of(s),
                                                     access::random_identity(), web::read_page(s.page)})},
          scpi{{pending_orders, lock, aborts, site->access}, s.silence},
          web_door{listen_at(io, s.address, s.http_port)},
          scpi_door{listen_at(io, s.address, s.scpi_port)} {
        if (!s.scpi_socket.empty()) local_door.emplace(io, s.scpi_socket);
        aborts.after([this](const std::string& by) { scpi.drop_waiting(by); });
    }

    /// Starts a task; an exception ends only the task.
    void start(const char* what, asio::awaitable<void> task) {
        asio::co_spawn(io, std::move(task), [this, what](const std::exception_ptr& exception) {
            if (exception) troubles.note(what, exception);
        });
    }

    /// Repeats a task for ever, also after an exception.
    template <class Task>
    asio::awaitable<void> repeat(const char* what, Task task) {
        for (;;) {
            try {
                co_await task();
            } catch (...) {
                troubles.note(what, std::current_exception());
            }
            access::ServerTimer pause{io, update_every};
            co_await pause.async_wait(use_awaitable);
        }
    }

    /// Returns when there is no free descriptor, or the client has disconnected already.
    template <class Acceptor, class Serve>
    asio::awaitable<void> accept(Acceptor& door, const char* what, Serve serve) {
        for (;;) {
            boost::system::error_code failed;
            auto socket = co_await door.async_accept(asio::redirect_error(use_awaitable, failed));
            if (failed) co_return;
            start(what, serve(std::move(socket)));
        }
    }

    asio::awaitable<void> serve_scpi(tcp::socket socket) {
        watch_over(socket);
        std::string name = name_of(socket);
        if (name.empty()) co_return;
        co_await scpi.serve(std::move(socket), std::move(name), scpi::Admission::password);
    }

    asio::awaitable<void> serve_local(LocalDoor::Protocol::socket socket) {
        std::string name = local_door->name_of(socket);
        co_await scpi.serve(std::move(socket), std::move(name), scpi::Admission::free);
    }

    void open_doors() {
        start("accepting of HTTP connections", repeat("accepting of HTTP connections", [this] {
                  return accept(web_door, "an HTTP connection", [this](tcp::socket socket) {
                      watch_over(socket);
                      return web::serve(std::move(socket), site);
                  });
              }));
        start("accepting of SCPI connections", repeat("accepting of SCPI connections", [this] {
                  return accept(scpi_door, "a SCPI connection",
                                [this](tcp::socket socket) { return serve_scpi(std::move(socket)); });
              }));
        if (local_door)
            start("accepting of local connections", repeat("accepting of local connections", [this] {
                      return accept(local_door->acceptor(), "a local connection",
                                    [this](auto socket) { return serve_local(std::move(socket)); });
                  }));
        start("housekeeping", repeat("housekeeping", [this] { return keep_house(); }));
        start("heartbeat", repeat("heartbeat", [this] { return beat(); }));
    }

    asio::awaitable<void> keep_house() {
        scpi.update();
        web::update(*site);
        site->served.scpi_clients = scpi.sessions();
        site->served.scpi_commands = scpi.messages();
        site->served.scpi_errors = scpi.errors();
        site->served.troubles = troubles.count();
        end_stale_control();
        co_return;
    }

    asio::awaitable<void> beat() {
        asio::steady_timer timer{io};
        for (;;) {
            heartbeat.beat();
            timer.expires_after(beat_every);
            co_await timer.async_wait(use_awaitable);
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

    /// Turns until the server ends. A function that throws does not end it.
    void run() {
        static_cast<void>(name_thread("remote"));
        for (bool running = true; running;) try {
                io.run();
                running = false;
            } catch (...) {
                troubles.note("a posted function", std::current_exception());
            }
    }
};

Server::Server(service::BenchPort& bench_port, const ServerSettings& settings,
               catalogue::Catalogue* recordings) {
    require_token(settings);
    state_ = std::make_unique<State>(bench_port, settings);
    State& s = *state_;
    s.site->recordings = recordings;
    s.scpi.set_streams(fmt::format("ws://{}:{}/ws", settings.address, http_port()));
    s.open_doors();
    s.thread = std::jthread{[&s] { s.run(); }};
    if (settings.fifo_priority > 0) s.priority.emplace(s.thread.native_handle(), settings.fifo_priority);
}

void Server::load_all() { web::load_encoder(); }

Server::~Server() {
    state_->priority.reset();
    state_->io.stop();
    if (state_->thread.joinable()) state_->thread.join();
    state_->letterbox->close();
}

// The page is read first: a folder that cannot be read leaves all settings as they are.
void Server::adopt(const ServerSettings& settings) {
    asio::post(state_->io, [this, settings] {
        auto page = web::read_page(settings.page);
        state_->site->access = access_of(settings);
        state_->site->page = std::move(page);
    });
}

bool Server::alive() const noexcept { return state_->heartbeat.age() < longest_pause; }
std::string Server::refused() const {
    const bool refused = state_->priority && !state_->priority->refused().empty();
    return refused ? "remote: an abort may wait for pictures: " + state_->priority->refused() : std::string{};
}
int Server::http_port() const noexcept { return state_->web_door.local_endpoint().port(); }
int Server::scpi_port() const noexcept { return state_->scpi_door.local_endpoint().port(); }

}  // namespace shaker::remote

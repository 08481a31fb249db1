#include "daemon/remote/web/web_client.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <optional>
#include <utility>

#include "daemon/remote/access/server_clock.hpp"
#include "daemon/remote/web/live_socket.hpp"
#include "daemon/remote/web/requests.hpp"
#include "drivers/descriptor.hpp"
#include "drivers/errors.hpp"
#include "drivers/realtime.hpp"

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/thread_pool.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/serializer.hpp>
#include <boost/beast/http/write.hpp>

namespace shaker::web {

namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using asio::use_awaitable;

constexpr std::size_t part_bytes = std::size_t{1} << 18U;
constexpr std::chrono::seconds part_patience{30};  // for the client to take a part

// A slow disk must not keep the doors from an abort.
asio::thread_pool& disk() {
    static asio::thread_pool thread{1};
    return thread;
}

/// An open recording, and its place among the downloads.
class Opened {
public:
    explicit Opened(Site& site) : site_{site} { ++site_.downloads; }
    Opened(const Opened&) = delete;
    Opened& operator=(const Opened&) = delete;
    ~Opened() { --site_.downloads; }
    Descriptor file;
    std::uint64_t bytes = 0;

private:
    Site& site_;
};

asio::awaitable<void> open_file(Opened& opened, const catalogue::Catalogue& recordings,
                                const catalogue::WantedFile& wanted) {
    use_ordinary_priority();  // the thread has that of the doors, which started it
    struct stat now {};
    try {
        opened.file = recordings.open(wanted);
        if (::fstat(opened.file, &now) == 0) opened.bytes = static_cast<std::uint64_t>(now.st_size);
    } catch (const InputError&) {
    }
    co_return;
}

asio::awaitable<std::size_t> read_part(int file, std::string& part) {
    const ssize_t n = ::read(file, part.data(), part.size());
    co_return n > 0 ? static_cast<std::size_t>(n) : 0;
}

bool may_send(const Site& site) {
    try {
        site.recordings->require_rest();
        return true;
    } catch (const InputError&) {
        return false;
    }
}

// Sends a file of the folder: a recording or a report; the connection must be closed afterwards. The disk is
// read in a thread of its own. Ends at once when the drive starts: the client then has less than
// Content-Length. alive: called for each part that was sent.
asio::awaitable<void> send_file(boost::beast::tcp_stream& stream, const Request& request,
                                const catalogue::WantedFile& wanted, Site& site,
                                const std::function<void()>& alive) {
    Opened opened{site};
    co_await asio::co_spawn(disk(), open_file(opened, *site.recordings, wanted), use_awaitable);
    http::response<http::empty_body> head{opened.file >= 0 ? http::status::ok : http::status::not_found,
                                          request.version()};
    if (wanted.report) {
        head.set(http::field::content_type, "text/html; charset=utf-8");
        head.set("Content-Security-Policy",
                 "sandbox; default-src 'none'; img-src data:; style-src 'unsafe-inline'");
    } else {
        head.set(http::field::content_type, "application/x-hdf5");
        head.set(http::field::content_disposition, "attachment; filename=\"" + wanted.name + "\"");
    }
    head.set(http::field::cache_control, "no-store");
    head.set("X-Content-Type-Options", "nosniff");
    head.keep_alive(false);
    head.content_length(opened.bytes);
    http::response_serializer<http::empty_body> headings{head};
    stream.expires_after(part_patience);
    co_await http::async_write_header(stream, headings, use_awaitable);
    std::string part(part_bytes, '\0');
    for (std::uint64_t sent = 0; sent < opened.bytes && may_send(site);) {
        std::size_t n = co_await asio::co_spawn(disk(), read_part(opened.file, part), use_awaitable);
        n = static_cast<std::size_t>(std::min<std::uint64_t>(n, opened.bytes - sent));
        if (n == 0) break;
        stream.expires_after(part_patience);
        co_await asio::async_write(stream, asio::buffer(part.data(), n), use_awaitable);
        sent += n;
        alive();
    }
}

constexpr std::chrono::milliseconds moment{50};      // for a request beyond the limit of connections
constexpr std::chrono::seconds request_patience{5};  // for a request that has begun, and for an answer

/// An entry in the list of guests for its lifetime.
class Seat {
public:
    Seat(Guests& guests, std::function<void()> leave)
        : guests_{guests}, place_{guests.enter(std::move(leave))} {}
    Seat(const Seat&) = delete;
    Seat& operator=(const Seat&) = delete;
    ~Seat() { guests_.gone(place_); }
    void heard() { guests_.heard(place_); }

private:
    Guests& guests_;
    Guests::Place place_;
};

// Number of connections above the limit, without those that are being closed.
int beyond(const Site& site) { return site.served.web_clients - site.guests.leaving() - site.most_clients; }

/// Increments a counter for its lifetime.
class Counted {
public:
    explicit Counted(int& count) : count_{count} { ++count_; }
    Counted(const Counted&) = delete;
    Counted& operator=(const Counted&) = delete;
    ~Counted() { --count_; }

private:
    int& count_;
};

// Waits for the result of an order, which the bench's thread executes, or until `bell` is cancelled.
asio::awaitable<Response> answered(const Request& request, Site& site, const std::string& who,
                                   access::ServerTimer& bell) {
    auto got = std::make_shared<std::optional<Response>>();
    auto ring = std::make_shared<access::ServerTimer*>(&bell);
    answer(request, site, who, [got, ring](Response r) {
        *got = std::move(r);
        if (*ring != nullptr) (*ring)->cancel();
    });
    if (!*got) {
        bell.expires_after(2 * request_patience);
        boost::system::error_code ignored;
        co_await bell.async_wait(asio::redirect_error(use_awaitable, ignored));
    }
    *ring = nullptr;
    if (!*got) co_return unanswered(request);
    co_return std::move(**got);
}

// Serves requests until the client closes (returns empty) or requests an upgrade to a socket (returned).
asio::awaitable<std::optional<Request>> converse(beast::tcp_stream& stream, Site& site,
                                                 const std::string& address) {
    access::ServerTimer bell{stream.get_executor()};
    Seat seat{site.guests, [&] {
                  stream.close();
                  bell.cancel();
              }};
    beast::flat_buffer buffer;
    for (;;) {
        RequestParser parser;
        set_limits(parser);
        stream.expires_after(request_patience);
        co_await http::async_read(stream, buffer, parser, use_awaitable);
        seat.heard();
        Request request = parser.release();
        ++site.served.requests;
        if (takes_socket(request, site)) co_return std::move(request);
        if (const auto file = wanted_file(request, site)) {
            co_await send_file(stream, request, *file, site, [&seat] { seat.heard(); });
            break;
        }
        const Response response = co_await answered(request, site, client_of(request, address), bell);
        if (response.result_int() >= 400) ++site.served.refused_requests;
        stream.expires_after(request_patience);
        co_await http::async_write(stream, response, use_awaitable);
        if (!response.keep_alive()) break;
    }
    boost::system::error_code ignored;
    stream.socket().shutdown(asio::ip::tcp::socket::shutdown_send, ignored);
    co_return std::nullopt;
}

asio::awaitable<void> attend(asio::ip::tcp::socket socket, const std::shared_ptr<Site>& site) {
    const std::string address = socket.remote_endpoint().address().to_string();
    beast::tcp_stream stream{std::move(socket)};
    const std::optional<Request> upgrade = co_await converse(stream, *site, address);
    if (!upgrade) co_return;
    const Counted counted{site->live_clients};
    stream.expires_never();
    co_await live(std::move(stream), *upgrade, site, client_of(*upgrade, address));
}

}  // namespace

// A client that disconnects, is slow or sends invalid data ends its own connection only.
asio::awaitable<void> serve(asio::ip::tcp::socket socket, std::shared_ptr<Site> site) {
    if (site->served.web_clients >= 2 * (site->most_clients + site->reserve)) co_return;
    if (beyond(*site) >= site->reserve) static_cast<void>(site->guests.ask_one_to_leave({}));
    const Counted counted{site->served.web_clients};
    try {
        co_await attend(std::move(socket), site);
    } catch (const std::exception&) {
    }
}

void update(Site& site) {
    site.actions.update();
    for (int n = beyond(site); n > 0 && site.guests.ask_one_to_leave(moment); --n) {
    }
}

}  // namespace shaker::web

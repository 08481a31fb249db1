#include "daemon/remote/web/web_client.hpp"

#include <chrono>
#include <optional>
#include <utility>

#include "daemon/remote/access/server_clock.hpp"
#include "daemon/remote/web/download.hpp"
#include "daemon/remote/web/live_socket.hpp"
#include "daemon/remote/web/requests.hpp"

#include <boost/asio/redirect_error.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>

namespace shaker::web {

namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using asio::use_awaitable;

constexpr std::chrono::milliseconds moment{50};  // for a request beyond the limit of connections
constexpr std::chrono::seconds patience{5};      // for a request that has begun, and for an answer

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
        bell.expires_after(2 * patience);
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
        stream.expires_after(patience);
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
        stream.expires_after(patience);
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

#pragma once
// The socket of a page. It sends the state ten times a second, events, and subscribed live streams. The first
// state and each state after a measurement include the points.
#include <chrono>
#include <cstddef>
#include <memory>
#include <string>
#include <boost/asio/awaitable.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http/message.hpp>
#include <boost/beast/http/string_body.hpp>
#include <boost/beast/websocket/stream.hpp>

namespace shaker::web {

inline constexpr std::size_t most_message = 4096;  // bytes, largest message of a client

/// Pings a client after 15 s of silence and closes the connection after 30 s.
template <class Next>
void set_limits(boost::beast::websocket::stream<Next>& socket) {
    boost::beast::websocket::stream_base::timeout limits{};
    limits.handshake_timeout = std::chrono::seconds{5};
    limits.idle_timeout = std::chrono::seconds{30};
    limits.keep_alive_pings = true;
    socket.set_option(limits);
    socket.read_message_max(most_message);
}

struct Site;

/// Accepts the upgrade and serves the socket until it closes. Throws when the connection fails.
boost::asio::awaitable<void> live(boost::beast::tcp_stream stream,
                                  const boost::beast::http::request<boost::beast::http::string_body>& request,
                                  std::shared_ptr<Site> site, const std::string& who);

}  // namespace shaker::web

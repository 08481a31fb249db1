#pragma once
// Limits of a live socket.
#include <chrono>
#include <cstddef>
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

}  // namespace shaker::web

#pragma once
// The socket of a page. It sends the state ten times a second, events, and subscribed live streams. The first
// state and each state after a measurement include the points.
#include <memory>
#include <string>
#include <utility>
#include <boost/asio/awaitable.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http/message.hpp>
#include <boost/beast/http/string_body.hpp>

namespace shaker::web {

struct Site;

/// Accepts the upgrade and serves the socket until it closes. Throws when the connection fails.
boost::asio::awaitable<void> live(boost::beast::tcp_stream stream,
                                  const boost::beast::http::request<boost::beast::http::string_body>& request,
                                  std::shared_ptr<Site> site, const std::string& who);

}  // namespace shaker::web

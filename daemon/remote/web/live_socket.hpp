#pragma once
// The socket of a page: the state ten times a second (in it the points at first and after a measurement),
// events, and the live streams it subscribed to.
#include <memory>
#include <string>
#include <utility>
#include <boost/asio/awaitable.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http/message.hpp>
#include <boost/beast/http/string_body.hpp>

namespace shaker::web {

struct Site;

/// Takes the upgrade and serves the socket to its end. Throws when the connection fails.
boost::asio::awaitable<void> live(boost::beast::tcp_stream stream,
                                  const boost::beast::http::request<boost::beast::http::string_body>& request,
                                  std::shared_ptr<Site> site, const std::string& who);

}  // namespace shaker::web

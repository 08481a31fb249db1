#pragma once
// One connection of a browser or a script: requests one after the other, or a socket with live streams.
#include <memory>

#include "daemon/remote/web/site.hpp"

#include <boost/asio/awaitable.hpp>
#include <boost/asio/ip/tcp.hpp>

namespace shaker::web {

/// Serves a connection until it closes. Never throws.
boost::asio::awaitable<void> serve(boost::asio::ip::tcp::socket socket, std::shared_ptr<Site> site);

/// Call it often. Answers aborts. Beyond the limit of connections, it closes those without a live socket that
/// have been silent longest.
void update(Site& site);

}  // namespace shaker::web

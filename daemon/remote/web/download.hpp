#pragma once
// The download of a recording or of a report.
#include <functional>
#include <string>

#include "daemon/remote/web/requests.hpp"

#include <boost/asio/awaitable.hpp>
#include <boost/beast/core/tcp_stream.hpp>

namespace shaker::web {

/// Sends a file of the folder; the connection must be closed afterwards. The disk is read in a thread of
/// its own. Ends at once when the drive starts: the client then has less than Content-Length. alive: called
/// for each part that was sent.
boost::asio::awaitable<void> send_file(boost::beast::tcp_stream& stream, const Request& request,
                                       const catalogue::WantedFile& wanted, Site& site,
                                       const std::function<void()>& alive);

}  // namespace shaker::web

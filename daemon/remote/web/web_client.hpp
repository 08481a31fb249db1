#pragma once
// One connection of a browser or a script: requests one after the other, or a socket with live streams.
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <utility>

#include "daemon/remote/web/site.hpp"

#include <boost/asio/awaitable.hpp>
#include <boost/asio/ip/tcp.hpp>

namespace shaker::web {

/// The page's files out of a folder: index.html, panel.js, panel.css. Those that are there.
std::map<std::string, PageFile> read_page(const std::filesystem::path& folder);

/// Serves it to its end. When there are as many as there may be, the one without a socket that was silent
/// for the longest gives way. Never throws.
boost::asio::awaitable<void> serve(boost::asio::ip::tcp::socket socket, std::shared_ptr<Site> site);

}  // namespace shaker::web

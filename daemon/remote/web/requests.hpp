#pragma once
// Answers to HTTP requests, and refusals.
#include <functional>
#include <optional>
#include <string>

#include "daemon/remote/web/site.hpp"

#include <boost/beast/http/message.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/string_body.hpp>

namespace shaker::web {

using Request = boost::beast::http::request<boost::beast::http::string_body>;
using Response = boost::beast::http::response<boost::beast::http::string_body>;
using RequestParser = boost::beast::http::request_parser<boost::beast::http::string_body>;

/// Sets the limits of header and body.
void set_limits(RequestParser& parser);
/// Name of the client for control and log: the name in the request, shortened and in printable characters,
/// and the address.
std::string client_of(const Request& request, const std::string& address);
/// True for an allowed upgrade to the live socket. All other requests are answered by answer().
bool takes_socket(const Request& request, const Site& site);
/// The recording or report that a request wants to download, of a site that may read it now. Other requests,
/// also those for a download that is refused, are answered by answer().
std::optional<catalogue::WantedFile> wanted_file(const Request& request, const Site& site);
/// Answers a request. `done` is called once, for an order when the bench has answered, otherwise at once.
void answer(const Request& request, Site& site, const std::string& who,
            const std::function<void(Response)>& done);
/// Response for an order that the bench did not answer in time.
Response unanswered(const Request& request);

}  // namespace shaker::web

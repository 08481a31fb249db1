#pragma once
// What a request over HTTP is answered with, and which are refused.
#include <functional>
#include <string>

#include "daemon/remote/web/site.hpp"

#include <boost/beast/http/message.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/string_body.hpp>

namespace shaker::web {

using Request = boost::beast::http::request<boost::beast::http::string_body>;
using Response = boost::beast::http::response<boost::beast::http::string_body>;
using RequestParser = boost::beast::http::request_parser<boost::beast::http::string_body>;

/// How long a header and a body may be.
void set_limits(RequestParser& parser);
/// Who asks, for control and the log: what it calls itself, cut and cleaned, and where it is.
std::string client_of(const Request& request, const std::string& address);
/// An upgrade to the live socket that is allowed. Everything else is answered.
bool takes_socket(const Request& request, const Site& site);
/// done is called once: at once, or, for an order, when the bench has answered.
void answer(const Request& request, Site& site, const std::string& who,
            const std::function<void(Response)>& done);
/// When it has not, for too long.
Response unanswered(const Request& request);

}  // namespace shaker::web

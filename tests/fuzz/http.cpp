// One connection over HTTP: requests one after the other, each answered as the daemon does.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>

#include "daemon/remote/web/requests.hpp"
#include "tests/fuzz/inline_bench.hpp"

#include <boost/asio/io_context.hpp>
#include <boost/beast/_experimental/test/stream.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http.hpp>

namespace {

using namespace shaker;
using namespace shaker::web;
using test::require;
namespace beast = boost::beast;
namespace http = beast::http;

constexpr const char* token = "0123456789abcdefghijkl";

std::string text(beast::string_view s) { return {s.data(), s.size()}; }

// Independent implementation of the daemon's access rules: true if the request may change or read data.
bool may(const web::Request& request, bool asks_token) {
    const std::string host = text(request[http::field::host]), origin = text(request[http::field::origin]);
    bool known = false;
    for (const char* name : {"localhost", "127.0.0.1", "[::1]"}) {
        const std::string start = text(host).substr(0, std::string_view{name}.size());
        const std::string behind = host.substr(start.size());
        known = known || (beast::iequals(start, name) && (behind.empty() || behind.front() == ':'));
    }
    const bool own = origin.empty() || origin == "http://" + host || origin == "https://" + host;
    if (!asks_token) return known && own;
    const std::string target = text(request.target()), word = std::string{"token="} + token;
    const bool told = text(request["X-Shaker-Token"]) == token ||
                      target.find("?" + word) != std::string::npos ||
                      target.find("&" + word) != std::string::npos;
    return known && own && told;
}

struct Seen {
    std::size_t orders;
    int aborts;
    std::string owner;
};

void look_at(const web::Response& response) {
    const unsigned status = response.result_int();
    require((status >= 200 && status < 300) || (status >= 400 && status < 600), "2xx, 4xx or 5xx");
    require(response.count(http::field::content_length) == 1 || status == 204, "a reply has a length");
    if (text(response[http::field::content_type]) == "application/json" && !response.body().empty())
        require(nlohmann::json::accept(response.body()), "a reply of type JSON is JSON");
    std::ostringstream out;
    out << response;
}

// Converts lines like "drive {...}" to valid requests, so that the fuzzer reaches the actions sooner.
std::string requests_of(std::string_view lines) {
    std::string out;
    while (!lines.empty()) {
        const std::string_view line = lines.substr(0, lines.find('\n'));
        const std::size_t name = std::min(line.find(' '), line.size());
        const std::string_view body = line.substr(std::min(name + 1, line.size()));
        out += "POST /api/" + std::string{line.substr(0, name)} +
               " HTTP/1.1\r\nHost: localhost\r\nX-Shaker-Token: " + token +
               "\r\nContent-Length: " + std::to_string(body.size()) + "\r\n\r\n" + std::string{body};
        lines.remove_prefix(std::min(line.size() + 1, lines.size()));
    }
    return out;
}

}  // namespace

// Bits of the first byte: a token is required; the bench answers in between; the other bytes are raw HTTP or
// lines of actions.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    if (size == 0) return 0;
    const bool with_token = (data[0] & 1U) != 0, prompt = (data[0] & 2U) == 0;
    test::InlineBench bench;
    web::Site site{.pending_orders = bench.pending_orders,
                   .lock = bench.lock,
                   .actions = web::Actions{bench.pending_orders, bench.lock, bench.aborts},
                   .access = {.hosts = {"localhost", "127.0.0.1", "[::1]"}, .token = with_token ? token : ""},
                   .page = {{"/", {"text/html", "the page"}}}};
    boost::asio::io_context io;
    beast::test::stream stream{io};
    const std::string_view bytes{reinterpret_cast<const char*>(data) + 1, size - 1};
    const std::string wire = (data[0] & 4U) != 0 ? requests_of(bytes) : std::string{bytes};
    stream.append({wire.data(), wire.size()});
    stream.close_remote();
    beast::flat_buffer buffer;
    for (;;) {
        web::RequestParser parser;
        set_limits(parser);
        beast::error_code failed;
        http::read(stream, buffer, parser, failed);
        if (failed) break;
        const web::Request request = parser.release();
        const auto seen = [&] {
            return Seen{bench.played.bench_port.ordered(), bench.played.aborts, bench.lock.owner()};
        };
        const Seen before = seen();
        if (takes_socket(request, site)) {
            require(may(request, with_token), "a socket only for allowed clients");
            break;
        }
        int answers = 0;
        std::optional<web::Response> response;
        const std::string who = client_of(request, "192.0.2.1");
        require(who.starts_with("page") && who.size() < 40, "a client's name is short");
        answer(request, site, who, [&](web::Response r) {
            ++answers;
            response = std::move(r);
        });
        if (answers == 0 && !prompt) response = unanswered(request);
        const Seen after = seen();
        bench.settle();
        site.actions.update();
        require(answers == 1, "one answer, once");
        look_at(*response);
        const std::string target = text(request.target());
        const bool private_path = (target.starts_with("/api/") || target.starts_with("/metrics")) &&
                                  target.substr(0, target.find('?')) != "/api/abort";
        if (after.aborts != before.aborts) require(may(request, false), "no abort by another site");
        if (after.orders != before.orders || after.owner != before.owner)
            require(may(request, with_token), "no action without permission");
        if (response->result_int() == 200)
            require(may(request, with_token && private_path), "no data without permission");
        if (!response->keep_alive()) break;
    }
    return 0;
}

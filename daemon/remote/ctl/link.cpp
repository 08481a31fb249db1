#include "daemon/remote/ctl/link.hpp"

#include <spdlog/fmt/fmt.h>
#include <sys/stat.h>

#include <algorithm>
#include <charconv>
#include <fstream>
#include <future>
#include <nlohmann/json.hpp>
#include <random>
#include <thread>
#include <utility>

#include "daemon/remote/ctl/outcome.hpp"
#include "drivers/errors.hpp"
#include "drivers/text/printable.hpp"

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>

namespace shaker::ctl {

namespace {

constexpr const char* default_port = "8080";
constexpr int most_port = 65535;

bool of_a_name(char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' ||
           c == '-' || c == '_';
}

bool of_a_number(char c) {
    return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f') || (c >= 'A' && c <= 'F') || c == ':' || c == '.';
}

bool is_port(std::string_view text) {
    int port = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), port);
    return error == std::errc{} && end == text.data() + text.size() && port >= 1 && port <= most_port;
}

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using boost::system::error_code;
using nlohmann::json;
using Request = http::request<http::string_body>;
using Response = http::response<http::string_body>;

constexpr std::uint64_t most_body = 64 << 20;  // bytes
constexpr std::size_t most_message = 16 << 20;

[[noreturn]] void not_reached(const Link& link, const std::string& why) {
    throw NotReached{link.at.text() + ": " + why};
}

void require(const Link& link, error_code failed) {
    if (failed == beast::error::timeout) not_reached(link, "no answer in time");
    if (failed == http::error::end_of_stream || failed == asio::error::eof)
        not_reached(link, "the connection was closed without an answer");
    if (failed == asio::error::connection_refused)
        throw NobodyListens{link.at.text() + ": " + failed.message() +
                            "; is \"shakerd serve\" running? --at or SHAKERD_URL gives another address"};
    if (failed) not_reached(link, failed.message());
}

// Asio's blocking calls have no time limit. An asynchronous operation with the stream's own limit has one.
template <class Start>
void finish(const Link& link, asio::io_context& io, Start start) {
    error_code result;
    start([&](error_code failed, auto&&...) { result = failed; });
    io.restart();
    io.run();
    require(link, result);
}

using Places = asio::ip::tcp::resolver::results_type;

// The system looks up a name without a time limit: in a thread that is left behind when it takes too long.
Places places_of(const Link& link, std::chrono::milliseconds within) {
    std::promise<std::pair<Places, error_code>> promise;
    auto future = promise.get_future();
    std::thread{[at = link.at, promise = std::move(promise)]() mutable {
        asio::io_context io;
        error_code unknown;
        Places found = asio::ip::tcp::resolver{io}.resolve(at.host, at.port, unknown);
        promise.set_value({std::move(found), unknown});
    }}.detach();
    if (future.wait_for(within) != std::future_status::ready)
        not_reached(link,
                    fmt::format("the address of \"{}\" was not found in time; use the address in numbers",
                                link.at.host));
    const auto [places, unknown] = future.get();
    require(link, unknown);
    return places;
}

// within: for the name; the stream has its own limit.
void connect(const Link& link, asio::io_context& io, beast::tcp_stream& stream,
             std::chrono::milliseconds within) {
    const Places places = places_of(link, within);
    finish(link, io, [&](auto done) { stream.async_connect(places, done); });
}

template <class Fields>
void sign(const Link& link, Fields& request) {
    request.set(http::field::user_agent, "shakerctl/" SHAKER_VERSION);
    request.set("X-Shaker-Client", link.client);
    if (!link.token.empty()) request.set("X-Shaker-Token", link.token);
}

// The reason in the refusal of the daemon. A refusal in another form does not come from shakerd.
[[noreturn]] void refuse(const Link& link, const Response& response) {
    const json reason = json::parse(response.body(), nullptr, false);
    if (reason.is_object() && reason.contains("error") && reason["error"].is_string())
        throw Refused{reason["error"].get<std::string>()};
    not_reached(link, fmt::format("the server there is not shakerd: HTTP status {}", response.result_int()));
}

std::string exchange(const Link& link, Request request, std::chrono::milliseconds within) {
    asio::io_context io{1};
    beast::tcp_stream stream{io};
    stream.expires_after(within);
    connect(link, io, stream, within);
    request.set(http::field::host, link.at.text());
    sign(link, request);
    request.keep_alive(false);
    request.prepare_payload();
    finish(link, io, [&](auto done) { http::async_write(stream, request, done); });
    beast::flat_buffer buffer;
    http::response_parser<http::string_body> parser;
    parser.body_limit(most_body);
    finish(link, io, [&](auto done) { http::async_read(stream, buffer, parser, done); });
    const Response response = parser.release();
    if (response.result_int() != 200) refuse(link, response);
    return response.body();
}

}  // namespace

std::string Address::text() const {
    const bool number = host.find(':') != std::string::npos;
    return (number ? "[" + host + "]" : host) + ":" + port;
}

Address address_of(std::string_view what, std::string_view url) {
    const auto refuse = [&](const std::string& why) {
        return InputError{fmt::format("{} \"{}\": {}; expected an address like {}", what, printable(url), why,
                                      default_url)};
    };
    std::string_view rest = url;
    if (rest.starts_with("https://")) throw refuse("the daemon speaks plain HTTP");
    if (rest.starts_with("http://")) rest.remove_prefix(7);
    if (rest.ends_with('/')) rest.remove_suffix(1);
    const bool bracket = rest.starts_with('[');
    const auto end = bracket ? rest.find(']') : rest.find(':');
    if (bracket && end == std::string_view::npos) throw refuse("a bracket is not closed");
    Address at{std::string{rest.substr(bracket, end == std::string_view::npos ? end : end - bracket)},
               default_port};
    if (at.host.empty() || !std::ranges::all_of(at.host, bracket ? of_a_number : of_a_name))
        throw refuse("host name or address expected");
    rest = end == std::string_view::npos ? std::string_view{} : rest.substr(end + (bracket ? 1 : 0));
    if (rest.empty()) return at;
    if (!rest.starts_with(':') || !is_port(rest.substr(1)))
        throw refuse(fmt::format("port 1 to {} expected after the host", most_port));
    at.port = rest.substr(1);
    return at;
}

std::string token_of_file(const std::filesystem::path& file) {
    struct stat facts {};
    if (::stat(file.c_str(), &facts) != 0)
        throw InputError{"--token-file " + file.string() + ": there is no such file"};
    if ((facts.st_mode & (S_IRWXG | S_IRWXO)) != 0)
        throw InputError{fmt::format("--token-file {}: other users can read it (mode {:o}); set mode 600",
                                     file.string(), facts.st_mode & 0777U)};
    std::string token;
    if (!(std::ifstream{file} >> token))
        throw InputError{"--token-file " + file.string() + ": no token in the file, or it cannot be read"};
    return checked_token("--token-file " + file.string(), token);
}

std::string checked_token(std::string_view what, std::string token) {
    if (!std::ranges::all_of(token, [](char c) { return c > ' ' && c < '\x7f'; }))
        throw InputError{
            fmt::format("{}: a token consists of visible ASCII characters without blanks", what)};
    return token;
}

std::string Link::get(const std::string& path) const {
    return exchange(*this, {http::verb::get, path, 11}, patience);
}

json Link::get_json(const std::string& path) const {
    json answer = json::parse(get(path), nullptr, false);
    if (!answer.is_object()) not_reached(*this, "what answers there is not shakerd");
    return answer;
}

void Link::order(const std::string& action, const json& fields, std::chrono::milliseconds within) const {
    Request request{http::verb::post, "/api/" + action, 11};
    request.set(http::field::content_type, "application/json");
    request.body() = fields.empty() ? "{}" : fields.dump();
    const json answer = json::parse(exchange(*this, std::move(request), within), nullptr, false);
    if (!answer.is_object() || answer.value("ok", json{}) != json(true))
        not_reached(*this, "what answers there is not shakerd");
}

std::string client_name() {
    std::random_device chance;
    std::uniform_int_distribution<int> letter{'a', 'z'};
    std::string name = "ctl";
    while (name.size() < 12) name += static_cast<char>(letter(chance));
    return name;
}

struct LiveMessages::Socket {
    Link link;
    asio::io_context io{1};
    beast::websocket::stream<beast::tcp_stream> stream{io};
    beast::flat_buffer buffer{};
};

LiveMessages::LiveMessages(const Link& link) : socket_{new Socket{.link = link}} {
    auto& stream = socket_->stream;
    beast::tcp_stream& tcp = beast::get_lowest_layer(stream);
    tcp.expires_after(patience);
    connect(link, socket_->io, tcp, patience);
    stream.read_message_max(most_message);
    stream.set_option(beast::websocket::stream_base::decorator(
        [&link](beast::websocket::request_type& request) { sign(link, request); }));
    Response answer;
    try {
        finish(link, socket_->io,
               [&](auto done) { stream.async_handshake(answer, link.at.text(), "/ws", done); });
    } catch (const NotReached&) {
        if (answer.result_int() < 400) throw;
        refuse(link, answer);
    }
}

LiveMessages::~LiveMessages() = default;

std::optional<json> LiveMessages::next(Clock::time_point until) {
    Socket& s = *socket_;
    const auto give_up = Clock::now() + patience;
    beast::get_lowest_layer(s.stream).expires_at(std::min(until, give_up));
    s.buffer.consume(s.buffer.size());
    try {
        finish(s.link, s.io, [&](auto done) { s.stream.async_read(s.buffer, done); });
    } catch (const NotReached&) {
        if (until < give_up && Clock::now() >= until) return std::nullopt;
        throw;
    }
    json message = json::parse(beast::buffers_to_string(s.buffer.data()), nullptr, false);
    if (!message.is_object() || !message.contains("type") || !message["type"].is_string())
        not_reached(s.link, "what answers there is not shakerd");
    return message;
}

}  // namespace shaker::ctl

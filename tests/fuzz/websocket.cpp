// One live socket: requests of its client as text and as bytes of the protocol.
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "daemon/remote/web/live_socket.hpp"
#include "daemon/remote/web/requests.hpp"
#include "daemon/remote/web/subscription.hpp"
#include "tests/fuzz/inline_bench.hpp"

#include <boost/asio/io_context.hpp>
#include <boost/beast/_experimental/test/stream.hpp>
#include <boost/beast/core/buffers_to_string.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/websocket.hpp>

namespace {

using namespace shaker::web;
using shaker::test::require;
namespace beast = boost::beast;
namespace http = beast::http;

struct Stream {
    Subscription wish;
};
using Streams = std::map<std::string, Stream>;

void obey(std::string_view text, Streams& streams) {
    const auto wish = wish_of(text);
    if (!wish) return;
    take(*wish, streams);
    require(streams.size() <= most_streams, "the number of streams is limited");
    for (const auto& [name, stream] : streams) {
        require(name.size() <= 64 && name == stream.wish.stream, "the requested stream");
        require(stream.wish.width >= 1 && stream.wish.width <= 4096, "a width of pixels");
        require(stream.wish.rate_hz >= 0.1 && stream.wish.rate_hz <= 30, "the rate is in its range");
    }
}

void read_lines(std::string_view text, Streams& streams) {
    while (!text.empty()) {
        const std::size_t end = std::min(text.find('\n'), text.size());
        obey(text.substr(0, end), streams);
        text.remove_prefix(std::min(end + 1, text.size()));
    }
}

void read_wire(std::string_view bytes, Streams& streams) {
    boost::asio::io_context io;
    beast::test::stream near{io}, far{io};
    near.connect(far);
    beast::websocket::stream<beast::test::stream> socket{std::move(near)};
    set_limits(socket);
    Request request{http::verb::get, "/ws", 11};
    request.set(http::field::host, "localhost");
    request.set(http::field::connection, "Upgrade");
    request.set(http::field::upgrade, "websocket");
    request.set(http::field::sec_websocket_key, "dGhlIHNhbXBsZSBub25jZQ==");
    request.set(http::field::sec_websocket_version, "13");
    beast::error_code failed;
    socket.accept(request, failed);
    require(!failed, "the upgrade is taken");
    socket.next_layer().append({bytes.data(), bytes.size()});
    far.close();
    beast::flat_buffer buffer;
    while (!failed) {
        socket.read(buffer, failed);
        require(buffer.size() <= most_message, "no message beyond the limit");
        if (failed) break;
        obey(beast::buffers_to_string(buffer.data()), streams);
        buffer.consume(buffer.size());
    }
}

}  // namespace

// First byte 't': the others are lines of text; otherwise: bytes of the protocol.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    if (size == 0) return 0;
    const std::string_view bytes{reinterpret_cast<const char*>(data) + 1, size - 1};
    Streams streams;
    if (data[0] == 't')
        read_lines(bytes, streams);
    else
        read_wire(bytes, streams);
    return 0;
}

#include "daemon/commissioning/doors.hpp"

#include <cstdint>
#include <istream>
#include <string>

#include "drivers/errors.hpp"

#include <boost/asio/connect.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/asio/read_until.hpp>
#include <boost/asio/streambuf.hpp>
#include <boost/asio/write.hpp>

namespace shaker::commissioning {

namespace asio = boost::asio;

namespace {

// The first line of the answer.
template <class Socket>
std::string ask(Socket& socket, const std::string& request) {
    asio::write(socket, asio::buffer(request));
    asio::streambuf answer;
    asio::read_until(socket, answer, '\n');
    std::istream in{&answer};
    std::string line;
    std::getline(in, line);
    return line;
}

void require(const std::string& answer, const std::string& wanted) {
    if (answer.find(wanted) == std::string::npos)
        throw DeviceError{"an abort was answered by \"" + answer + "\", not by " + wanted};
}

asio::ip::tcp::socket connected(asio::io_context& io, int port) {
    asio::ip::tcp::socket socket{io};
    socket.connect({asio::ip::address_v4::loopback(), static_cast<std::uint16_t>(port)});
    return socket;
}

}  // namespace

void abort_by_scpi(int port) {
    asio::io_context io;
    asio::ip::tcp::socket socket = connected(io, port);
    require(ask(socket, "ABOR?\n"), "1");
}

void abort_by_socket(const std::filesystem::path& path) {
    asio::io_context io;
    asio::local::stream_protocol::socket socket{io};
    socket.connect(asio::local::stream_protocol::endpoint{path.string()});
    require(ask(socket, "ABOR?\n"), "1");
}

void abort_by_http(int port) {
    asio::io_context io;
    asio::ip::tcp::socket socket = connected(io, port);
    require(ask(socket, "POST /api/abort HTTP/1.1\r\nHost: localhost\r\nContent-Length: 0\r\n\r\n"), "200");
}

}  // namespace shaker::commissioning

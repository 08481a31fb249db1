#pragma once
// Opens the doors of the server: TCP ports and the Unix socket for scripts on the bench's computer.
#include <filesystem>
#include <string>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/local/stream_protocol.hpp>

namespace shaker::remote {

/// DeviceError naming address and port when they cannot be used.
boost::asio::ip::tcp::acceptor listen_at(boost::asio::io_context& io, const std::string& address, int port);

/// Closes a connection to a dead machine or network after two minutes, also when nothing is sent.
void watch_over(boost::asio::ip::tcp::socket& socket);

/// Address and port of a client; empty when it has disconnected.
std::string name_of(const boost::asio::ip::tcp::socket& socket);

/// A Unix socket in a folder, for the user and the group of the daemon (mode 0660).
class LocalDoor {
public:
    using Protocol = boost::asio::local::stream_protocol;

    /// Replaces a socket of that name on which nobody listens. DeviceError naming the path when it cannot be
    /// used: another daemon listens, a file of another kind, no such folder.
    LocalDoor(boost::asio::io_context& io, std::filesystem::path path);
    /// Removes the socket.
    ~LocalDoor();
    LocalDoor(const LocalDoor&) = delete;
    LocalDoor& operator=(const LocalDoor&) = delete;

    [[nodiscard]] Protocol::acceptor& acceptor() noexcept { return acceptor_; }
    /// User and process of a client, and the number of its connection.
    std::string name_of(Protocol::socket& socket);

private:
    std::filesystem::path path_;
    Protocol::acceptor acceptor_;
    unsigned clients_ = 0;
};

}  // namespace shaker::remote

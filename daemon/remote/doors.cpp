#include "daemon/remote/doors.hpp"

#include <netinet/tcp.h>
#include <spdlog/fmt/fmt.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <utility>

#include "drivers/errors.hpp"

#include <boost/asio/detail/socket_option.hpp>

namespace shaker::remote {

namespace asio = boost::asio;
using asio::ip::tcp;

namespace {

constexpr mode_t user_and_group = S_IRUSR | S_IWUSR | S_IRGRP | S_IWGRP;

bool is_socket(const std::filesystem::path& path) {
    struct stat facts {};
    return ::lstat(path.c_str(), &facts) == 0 && S_ISSOCK(facts.st_mode);
}

// Removes the socket that a daemon left behind when it was killed.
void remove_left_behind(asio::io_context& io, const LocalDoor::Protocol::endpoint& at) {
    LocalDoor::Protocol::socket caller{io};
    boost::system::error_code failed;
    caller.connect(at, failed);
    if (failed == asio::error::connection_refused && is_socket(at.path())) ::unlink(at.path().c_str());
}

}  // namespace

tcp::acceptor listen_at(asio::io_context& io, const std::string& address, int port) {
    try {
        tcp::acceptor acceptor{io, {asio::ip::make_address(address), static_cast<unsigned short>(port)}};
        return acceptor;
    } catch (const boost::system::system_error& e) {
        const char* next = "";
        if (e.code() == boost::asio::error::address_in_use)
            next =
                "; another program, perhaps another shakerd, has this port: end it, or give --http-port and "
                "--scpi-port";
        throw DeviceError{fmt::format("{} port {}: {}{}", address, port, e.code().message(), next)};
    }
}

void watch_over(tcp::socket& socket) {
    using namespace boost::asio::detail::socket_option;
    boost::system::error_code ignored;
    socket.set_option(tcp::no_delay{true}, ignored);
    socket.set_option(asio::socket_base::keep_alive{true}, ignored);
    socket.set_option(integer<IPPROTO_TCP, TCP_KEEPIDLE>{60}, ignored);
    socket.set_option(integer<IPPROTO_TCP, TCP_KEEPINTVL>{10}, ignored);
    socket.set_option(integer<IPPROTO_TCP, TCP_KEEPCNT>{6}, ignored);
    socket.set_option(integer<IPPROTO_TCP, TCP_USER_TIMEOUT>{120'000}, ignored);  // ms
}

std::string name_of(const tcp::socket& socket) {
    boost::system::error_code gone;
    const auto end = socket.remote_endpoint(gone);
    if (gone) return {};
    return fmt::format("{}:{}", end.address().to_string(), end.port());
}

// Nobody can connect before listen(), so the mode holds for every client.
LocalDoor::LocalDoor(asio::io_context& io, std::filesystem::path path)
    : path_{std::move(path)}, acceptor_{io} {
    try {
        const Protocol::endpoint at{path_.string()};
        remove_left_behind(io, at);
        acceptor_.open();
        acceptor_.bind(at);
        if (::chmod(path_.c_str(), user_and_group) != 0)
            throw boost::system::system_error{errno, boost::system::system_category()};
        acceptor_.listen();
    } catch (const boost::system::system_error& e) {
        throw DeviceError{fmt::format("scpi_socket {}: {}", path_.string(), e.code().message())};
    }
}

LocalDoor::~LocalDoor() { ::unlink(path_.c_str()); }

std::string LocalDoor::name_of(Protocol::socket& socket) {
    ucred peer{};
    socklen_t size = sizeof peer;
    const bool known = ::getsockopt(socket.native_handle(), SOL_SOCKET, SO_PEERCRED, &peer, &size) == 0;
    ++clients_;
    if (!known) return fmt::format("local client {}", clients_);
    return fmt::format("local client {} (user {}, process {})", clients_, peer.uid, peer.pid);
}

}  // namespace shaker::remote

#include "tests/mock/loopback.hpp"

#include <arpa/inet.h>
#include <net/if.h>
#include <netinet/in.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "drivers/descriptor.hpp"

namespace shaker::mock {
namespace {

std::string refusal(const std::string& what) { return what + ": " + std::strerror(errno); }

ifreq request(const std::string& name) {
    ifreq r{};
    name.copy(r.ifr_name, IFNAMSIZ - 1);
    return r;
}

/// bind() works for all of 127.0.0.0/8; this checks the addresses of the interface.
bool is_listed(int fd, const in_addr& address) {
    for (int i = 0; i < 64; ++i) {
        ifreq r = request(i == 0 ? "lo" : "lo:" + std::to_string(i));
        if (ioctl(fd, SIOCGIFADDR, &r) != 0) continue;
        sockaddr_in found{};
        std::memcpy(&found, &r.ifr_addr, sizeof found);
        if (found.sin_addr.s_addr == address.s_addr) return true;
    }
    return false;
}

/// The first alias of the loopback interface without an address.
std::string free_alias(int fd) {
    for (int i = 1; i < 64; ++i) {
        std::string name = "lo:" + std::to_string(i);
        ifreq r = request(name);
        if (ioctl(fd, SIOCGIFADDR, &r) != 0) return name;
    }
    return "lo:64";
}

std::string add(int fd, const std::string& text) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    if (inet_pton(AF_INET, text.c_str(), &address.sin_addr) != 1) return text + " is not an IPv4 address";
    if ((ntohl(address.sin_addr.s_addr) >> 24) != 127) return text + " is not in 127.0.0.0/8";
    if (is_listed(fd, address.sin_addr)) return {};
    ifreq r = request(free_alias(fd));
    std::memcpy(&r.ifr_addr, &address, sizeof address);
    return ioctl(fd, SIOCSIFADDR, &r) == 0 ? std::string{} : refusal("address " + text + " cannot be added");
}

}  // namespace

std::string add_loopback_addresses(std::span<const std::string> addresses) {
    const Descriptor s{socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)};
    if (s < 0) return refusal("cannot create a socket");
    ifreq r = request("lo");
    if (ioctl(s, SIOCGIFFLAGS, &r) != 0) return refusal("no loopback interface");
    if ((r.ifr_flags & IFF_UP) == 0) {
        r.ifr_flags = static_cast<short>(r.ifr_flags | IFF_UP);
        if (ioctl(s, SIOCSIFFLAGS, &r) != 0) return refusal("cannot bring up the loopback interface");
    }
    for (const std::string& address : addresses)
        if (std::string why = add(s, address); !why.empty()) return why;
    return {};
}

std::string enter_private_network(std::span<const std::string> addresses) {
    if (unshare(CLONE_NEWNET) != 0 && unshare(CLONE_NEWUSER | CLONE_NEWNET) != 0)
        return refusal("cannot create a private network");
    return add_loopback_addresses(addresses);
}

}  // namespace shaker::mock

#pragma once
// Addresses of their own for mock cameras on this computer: the control channel of GigE Vision has one fixed
// port, so each camera needs an address. 127.0.0.1 is there always; others of 127.0.0.0/8 must be added.
#include <span>
#include <string>

namespace shaker {

/// Adds addresses (127.x.y.z) to the loopback interface and brings it up. Needs CAP_NET_ADMIN. Returns what
/// was refused, in words; empty when all are there. Adding one that is there already is no error.
[[nodiscard]] std::string add_loopback_addresses(std::span<const std::string> addresses);

/// Moves the calling thread, and the threads and programs that it starts afterwards, into a network of their
/// own that has only a loopback interface, with these addresses added to 127.0.0.1. Nothing outside sees it
/// and nothing of it stays. Asks for a user namespace too where the caller is not root; the kernel grants
/// that only while the process has one thread. Returns what was refused, in words; empty when done.
[[nodiscard]] std::string enter_private_network(std::span<const std::string> addresses);

}  // namespace shaker

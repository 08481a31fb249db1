#pragma once
// Loopback addresses for mock cameras: the control channel of GigE Vision has one fixed port, so each camera
// needs its own address. 127.0.0.1 always exists; others of 127.0.0.0/8 must be added.
#include <span>
#include <string>

namespace shaker::mock {

/// Adds addresses (127.x.y.z) to the loopback interface and brings it up. Requires CAP_NET_ADMIN. Returns the
/// error as text; empty on success. Existing addresses are not an error.
[[nodiscard]] std::string add_loopback_addresses(std::span<const std::string> addresses);

/// Moves the calling thread, and threads and programs that it starts later, into a private network with only
/// a loopback interface, 127.0.0.1 and these addresses. It is invisible from outside and disappears with its
/// last process. Creates a user namespace too if the caller is not root, which the kernel allows only while
/// the process has one thread. Returns the error as text; empty on success.
[[nodiscard]] std::string enter_private_network(std::span<const std::string> addresses);

}  // namespace shaker::mock

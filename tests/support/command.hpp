#pragma once
// Runs a command among mock devices, in a network that nobody else sees.
#include <functional>
#include <span>
#include <string>

namespace shaker::test {

/// The body of a program that is called as NAME COMMAND [ARGUMENT...]: moves into a network of its own with
/// 127.0.0.1 and these addresses, then calls `among`, which makes its devices and calls what it is given to
/// run the command to its end. Returns what the program exits with: the command's status (128 + n when signal
/// n ended it, 127 when it could not be started), 77 when the kernel refuses the network, 2 without a
/// command, 1 after an exception; with words on standard error.
int run_among_mocks(std::span<char* const> arguments, std::span<const std::string> addresses,
                    const std::function<int(const std::function<int()>&)>& among);

}  // namespace shaker::test

#pragma once
// Runs a command with mock devices in a private network namespace.
#include <functional>
#include <span>
#include <string>

namespace shaker::test {

/// The body of a program that is called as NAME COMMAND [ARGUMENT...]. It enters a private network with
/// 127.0.0.1 and these addresses and calls `among`, which creates devices and calls its argument to run the
/// command. Returns the exit status: that of the command (128 + n after signal n, 127 if it could not be
/// started), 77 if the kernel refuses the network, 2 without a command, 1 after an exception. Errors go to
/// standard error.
int run_among_mocks(std::span<char* const> arguments, std::span<const std::string> addresses,
                    const std::function<int(const std::function<int()>&)>& among);

}  // namespace shaker::test

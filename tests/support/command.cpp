#include "tests/support/command.hpp"

#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstring>
#include <exception>
#include <iostream>

#include "tests/mock/loopback.hpp"

namespace shaker::test {
namespace {

int run(char* const* command) {
    pid_t pid = 0;
    if (const int error = posix_spawnp(&pid, command[0], nullptr, nullptr, command, environ); error != 0) {
        std::cerr << command[0] << ": " << std::strerror(error) << '\n';
        return 127;
    }
    int status = 0;
    waitpid(pid, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

}  // namespace

int run_among_mocks(std::span<char* const> arguments, std::span<const std::string> addresses,
                    const std::function<int(const std::function<int()>&)>& among) try {
    if (arguments.size() < 2) {
        std::cerr << "usage: " << arguments[0] << " COMMAND [ARGUMENT...]\n";
        return 2;
    }
    if (const std::string refused = mock::enter_private_network(addresses); !refused.empty()) {
        std::cerr << refused << '\n';
        return 77;
    }
    return among([&] { return run(&arguments[1]); });
} catch (const std::exception& error) {
    std::cerr << arguments[0] << ": " << error.what() << '\n';
    return 1;
}

}  // namespace shaker::test

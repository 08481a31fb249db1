// shakerctl: command-line client of "shakerd serve".
#include <csignal>
#include <cstdio>
#include <exception>

#include "daemon/remote/ctl/command_line.hpp"
#include "daemon/remote/ctl/trouble.hpp"

int main(int argc, char** argv) try {
    std::signal(SIGPIPE, SIG_IGN);  // the reader of a pipe may exit first
    return shaker::ctl::command_line(argc, argv);
} catch (const std::exception& e) {
    std::fprintf(stderr, "shakerctl: %s\n", e.what());
    return shaker::ctl::exit_failure;
}

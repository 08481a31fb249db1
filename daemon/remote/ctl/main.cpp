// shakerctl: command-line client of "shakerd serve".
#include <csignal>
#include <cstdio>
#include <exception>

#include "daemon/manual/parser.hpp"
#include "daemon/remote/ctl/outcome.hpp"
#include "daemon/remote/ctl/table.hpp"
#include "drivers/errors.hpp"
#include "drivers/text/printable.hpp"

namespace shaker::ctl {
namespace {

int report(const std::exception& e, int status) {
    std::fputs(("shakerctl: " + printable(e.what()) + "\n").c_str(), stderr);
    return status;
}

// Runs the command and returns the exit status; reports errors on standard error.
int command_line(int argc, const char* const* argv) try {
    const manual::ParsedLine line = manual::parse(program(), argc, argv);
    if (!line.text.empty()) {
        print(line.text);
        return exit_done;
    }
    return line.command->act(line.values);
} catch (const Refused& e) {
    return report(e, exit_refused);
} catch (const InputError& e) {
    return report(e, exit_wrong_use);
} catch (const NotReached& e) {
    return report(e, exit_not_reached);
} catch (const TimedOut& e) {
    return report(e, exit_timed_out);
} catch (const NotWritten& e) {
    return nobody_reads() ? exit_done : report(e, exit_not_written);
}

}  // namespace
}  // namespace shaker::ctl

int main(int argc, char** argv) try {
    std::signal(SIGPIPE, SIG_IGN);  // the reader of a pipe may exit first
    return shaker::ctl::command_line(argc, argv);
} catch (const std::exception& e) {
    std::fprintf(stderr, "shakerctl: %s\n", e.what());
    return shaker::ctl::exit_failure;
}

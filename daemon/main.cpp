// shakerd: drives a shaker, measures base and walker, reduces, records and replays.
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <csignal>

#include "daemon/commands/table.hpp"
#include "daemon/manual/command.hpp"
#include "daemon/report/printing.hpp"

int main(int argc, char** argv) {
    std::signal(SIGXFSZ,
                SIG_IGN);  // a limit of the file size is a failure of the disk, with the name of the file
    return shaker::manual::exit_status_of([&] {
        spdlog::set_default_logger(spdlog::stderr_color_mt("shakerd"));
        spdlog::set_formatter(shaker::report::log_format());
        return shaker::commands::run_command_line(argc, argv);
    });
}

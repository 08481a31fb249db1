// shakerd: drives a shaker, measures base and walker, reduces, records and replays.
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include "daemon/command_line.hpp"
#include "daemon/exit_status.hpp"
#include "daemon/remote/serve_command.hpp"

int main(int argc, char** argv) {
    return shaker::exit_status_of([&] {
        spdlog::set_default_logger(spdlog::stderr_color_mt("shakerd"));
        spdlog::set_pattern("%v");
        return shaker::command_line(argc, argv, shaker::serve);
    });
}

// shakerd: drives a shaker, measures base and walker, reduces, records and replays.
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <exception>

#include "daemon/command_line.hpp"
#include "drivers/errors.hpp"

int main(int argc, char** argv) try {
    spdlog::set_default_logger(spdlog::stderr_color_mt("shakerd"));
    spdlog::set_pattern("%v");
    return shaker::command_line(argc, argv);
} catch (const shaker::InputError& e) {
    spdlog::error("shakerd: {}", e.what());
    return shaker::exit_input;
} catch (const shaker::DeviceError& e) {
    spdlog::error("shakerd: {}", e.what());
    return shaker::exit_device;
} catch (const shaker::TripError& e) {
    spdlog::error("shakerd: the drive was stopped: {}", e.what());
    return shaker::exit_tripped;
} catch (const std::exception& e) {
    spdlog::critical("shakerd: {}", e.what());
    return shaker::exit_failure;
}

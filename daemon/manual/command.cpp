#include "daemon/manual/command.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <exception>
#include <filesystem>

#include "drivers/errors.hpp"

namespace shaker::manual {

int exit_status_of(const std::function<int()>& work) try { return work(); } catch (const InputError& e) {
    spdlog::error("shakerd: {}", e.what());
    return exit_input;
} catch (const DeviceError& e) {
    spdlog::error("shakerd: {}", e.what());
    return exit_device;
} catch (const TripError& e) {
    spdlog::error("shakerd: the drive was stopped: {}", e.what());
    return exit_tripped;
} catch (const Interrupted& e) {
    spdlog::error("shakerd: {}", e.what());
    return exit_signal + e.signal;
} catch (const std::filesystem::filesystem_error& e) {
    spdlog::error("shakerd: {}: {}", e.path1().string(), e.code().message());
    return exit_device;
} catch (const std::exception& e) {
    spdlog::critical("shakerd: {}", e.what());
    return exit_failure;
}

const Command* find(const Program& program, std::string_view name) {
    const auto found = std::ranges::find(program.commands, name, &Command::name);
    return found == program.commands.end() ? nullptr : &*found;
}

bool may_end_with(const Command& command, const ExitStatus& status) {
    return status.of_every_command ||
           std::ranges::find(command.exit_statuses, status.number) != command.exit_statuses.end();
}

}  // namespace shaker::manual

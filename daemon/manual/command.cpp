#include "daemon/manual/command.hpp"

#include <algorithm>

namespace shaker::manual {

const Command* find(const Program& program, std::string_view name) {
    const auto found = std::ranges::find(program.commands, name, &Command::name);
    return found == program.commands.end() ? nullptr : &*found;
}

bool may_end_with(const Command& command, const ExitStatus& status) {
    return status.of_every_command ||
           std::ranges::find(command.exit_statuses, status.number) != command.exit_statuses.end();
}

}  // namespace shaker::manual

#pragma once
// Recovery of a recording by a confined child.
#include "daemon/commands/recover_command.hpp"

namespace shaker::command_line {

/// As commands::recover(), in a confined child; the recovered file gets its name. Exit status of the child.
int recover_confined(commands::RecoverOptions options);

}  // namespace shaker::command_line

#pragma once
// The program's command line: commands, options with units, help.

#include <functional>

#include "daemon/commands.hpp"

namespace shaker {

/// Does what the command line asks; `serve` is the command of that name, which needs more than this library
/// has. Returns the exit status; throws what the command throws.
int command_line(int argc, char** argv, const std::function<void(const ServeOptions&)>& serve);

}  // namespace shaker

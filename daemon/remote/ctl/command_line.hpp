#pragma once
// The command line of shakerctl, made from its table.
#include <string>

namespace shaker::ctl {

/// Does what is asked and returns the exit status; says on standard error what went wrong.
int command_line(int argc, const char* const* argv);

/// What "shakerctl --help" prints, or with a command what "shakerctl COMMAND --help" prints.
std::string help(const std::string& command = {});

}  // namespace shaker::ctl

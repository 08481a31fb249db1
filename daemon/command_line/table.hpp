#pragma once
// The commands of shakerd as one table: parsing, help and manual page are made from it.
#include "daemon/manual/command.hpp"

namespace shaker::command_line {

/// To add a command: write its row in a file of this folder, name the row in rows.hpp and in table.cpp.
const manual::Program& program();

/// Runs the command and returns the exit status. Throws InputError for a wrong command line, and the
/// exceptions of the command.
int run_command_line(int argc, const char* const* argv);

}  // namespace shaker::command_line

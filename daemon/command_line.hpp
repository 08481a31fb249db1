#pragma once
// The program's command line: commands, options with units, help.

namespace shaker {

/// Does what the command line asks. Returns the exit status; throws what the command throws.
int command_line(int argc, char** argv);

}  // namespace shaker

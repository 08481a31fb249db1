#pragma once
// The program's command line: commands, options with units, help, exit statuses.

namespace shaker {

inline constexpr int exit_ok = 0;
inline constexpr int exit_failure = 1;  // something that should not happen
inline constexpr int exit_input = 2;    // command line, settings or a file's content; nothing was written
inline constexpr int exit_device = 3;   // a device or the disk failed
inline constexpr int exit_tripped = 5;  // a limit stopped the drive
inline constexpr int exit_not_identical = 4;  // replay: the results are not the recorded ones

/// Does what the command line asks. Returns the exit status; throws what the command throws.
int command_line(int argc, char** argv);

}  // namespace shaker

#pragma once
// The command line of shakerctl, by its table.

namespace shaker::ctl {

/// Runs the command and returns the exit status; reports errors on standard error.
int command_line(int argc, const char* const* argv);

}  // namespace shaker::ctl

#pragma once
// The commands of shakerd as one table: parsing, help and manual page are made from it.
#include "daemon/manual/command.hpp"

namespace shaker::commands {

/// To add a command: write its row in a file of this folder, name it below and in table.cpp.
const manual::Program& program();

/// Runs the command and returns the exit status. Throws InputError for a wrong command line, and the
/// exceptions of the command.
int run_command_line(int argc, const char* const* argv);

// The rows.
manual::Command run_row();
manual::Command calibrate_row();
manual::Command campaign_row();
manual::Command mu_row();
manual::Command law_row();
manual::Command serve_row();
manual::Command check_row();
manual::Command devices_row();
manual::Command list_row();
manual::Command replay_row();
manual::Command recover_row();
manual::Command export_row();
manual::Command report_row();
manual::Command reduce_row();
manual::Command track_row();
manual::Command example_row();
manual::Command predict_row();

}  // namespace shaker::commands

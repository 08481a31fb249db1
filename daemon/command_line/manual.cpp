#include <cstdio>

#include "daemon/command_line/rows.hpp"
#include "daemon/command_line/table.hpp"
#include "daemon/manual/help.hpp"

namespace shaker::command_line {

namespace {

int print_manual(const manual::Values& /*values*/) {
    std::fputs(manual::manual_page(program()).c_str(), stdout);
    return manual::exit_ok;
}

}  // namespace

manual::Command manual_row() {
    return {.name = "manual", .summary = "Print the manual page, for man -l", .act = print_manual};
}

}  // namespace shaker::command_line

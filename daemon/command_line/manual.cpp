#include <cstdio>

#include "daemon/command_line/rows.hpp"
#include "daemon/command_line/table.hpp"
#include "daemon/manual/completion.hpp"
#include "daemon/manual/manual_page.hpp"

namespace shaker::command_line {

namespace {

constexpr std::array completion_arguments{manual::Argument{
    .name = "SHELL", .help = "bash, zsh or fish", .kind = manual::Kind::word, .words = manual::shells}};

int print(const std::string& text) {
    std::fputs(text.c_str(), stdout);
    return manual::exit_ok;
}

int print_completion(const manual::Values& values) {
    return print(manual::completion(program(), values.text("SHELL")));
}

int print_manual(const manual::Values& /*values*/) { return print(manual::manual_page(program())); }

}  // namespace

manual::Command completion_row() {
    return {.name = "completion",
            .summary = "Print the completion script for a shell",
            .details = "In bash: source <(shakerd completion bash)",
            .arguments = completion_arguments,
            .act = print_completion};
}

manual::Command manual_row() {
    return {.name = "manual", .summary = "Print the manual page, for man -l", .act = print_manual};
}

}  // namespace shaker::command_line

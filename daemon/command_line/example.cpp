#include <cstdio>
#include <filesystem>

#include "daemon/command_line/rows.hpp"
#include "daemon/commands/example_command.hpp"

namespace shaker::command_line {

namespace {

constexpr std::array arguments{
    manual::Argument{.name = "FOLDER", .help = "Folder of the new files", .kind = manual::Kind::folder}};

int act(const manual::Values& values) {
    const std::filesystem::path folder = values.text("FOLDER");
    commands::write_example_session(folder);
    std::puts((folder / "session.toml").string().c_str());
    return manual::exit_ok;
}

}  // namespace

manual::Command example_row() {
    return {.name = "example",
            .summary = "Write a small session of footage from the simulated bench",
            .details =
                "The session holds two movies, accelerations as CSV, session.toml and the truth. Files "
                "that exist are never replaced.",
            .arguments = arguments,
            .example = "shakerd example lab; shakerd reduce lab/session.toml",
            .exit_statuses = {manual::exit_device},
            .act = act};
}

}  // namespace shaker::command_line

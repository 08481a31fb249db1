#include "daemon/command_line/rows.hpp"
#include "daemon/commands/recover_command.hpp"
#include "daemon/sandbox/confined.hpp"

namespace shaker::command_line {

namespace {

constexpr std::array arguments{
    manual::Argument{.name = "FILE", .help = "Recording, or its .part", .kind = manual::Kind::file},
    json_argument};

int act(const manual::Values& values) {
    const commands::RecoverOptions options{.file = values.text("FILE"), .json = values.has("--json")};
    sandbox::Confinement allowed = sandbox::confinement_for(options.file);
    allowed.writes_files = true;
    return confined(options.file.string(), allowed,
                    [&] { return recover(options) ? manual::exit_ok : manual::exit_not_identical; });
}

}  // namespace

manual::Command recover_row() {
    return {.name = "recover",
            .summary = "Finish a recording after a crash, or verify a finished one",
            .details = "The .part file is not changed. Exit status 4 means that a finished file was changed.",
            .arguments = arguments,
            .example = "shakerd recover run.nxs.part",
            .exit_statuses = {manual::exit_device, manual::exit_not_identical},
            .act = act};
}

}  // namespace shaker::command_line

#include <algorithm>

#include "daemon/command_line/rows.hpp"
#include "daemon/commands/list_command.hpp"
#include "daemon/sandbox/confined.hpp"

namespace shaker::command_line {

namespace {

using manual::Argument;
using manual::Kind;

constexpr std::array arguments{
    Argument{.name = "FILE",
             .help = "Recording; several are listed one after the other",
             .kind = Kind::file,
             .many = true},
    Argument{.name = "--json", .help = "Print one JSON object a line; key names carry the SI units"}};

int act(const manual::Values& values) {
    int status = manual::exit_ok;
    for (const std::string& file : values.texts("FILE"))
        status = std::max(status, sandbox::confined(file, sandbox::confinement_for(file), [&] {
                              commands::list_recording(file, values.has("--json"));
                              return manual::exit_ok;
                          }));
    return status;
}

}  // namespace

manual::Command list_row() {
    return {
        .name = "list",
        .summary = "List set-points, results, outcome and remarks of recordings",
        .details = "The results are those that the recording has; \"shakerd replay\" computes them again.",
        .arguments = arguments,
        .example = "shakerd list *.nxs",
        .exit_statuses = {manual::exit_device},
        .act = act};
}

}  // namespace shaker::command_line

#include "daemon/command_line/rows.hpp"
#include "daemon/commands/replay_command.hpp"
#include "daemon/sandbox/confined.hpp"

namespace shaker::command_line {

namespace {

using manual::Argument;
using manual::Kind;

constexpr std::array<std::string_view, 3> from_words{"best", "raw", "tracks"};

constexpr std::array arguments{
    recording_argument,
    Argument{.name = "--from",
             .help = "Source. raw: the pictures; tracks: the stored positions; best: raw if every picture "
                     "was kept and "
                     "this version follows targets as the one that recorded the file",
             .kind = Kind::word,
             .words = from_words,
             .standard = "best"},
    Argument{.name = "--set",
             .value = "KEY=VALUE",
             .help = "Reduce with this setting and print the changes, e.g. top.mm_per_px=0.1 or from_s=3.5; "
                     "an unknown "
                     "key lists all keys",
             .kind = Kind::text,
             .many = true},
    json_argument};

int act(const manual::Values& values) {
    using From = commands::ReplayOptions::From;
    const std::string from = values.text("--from");
    const commands::ReplayOptions options{.file = values.text("FILE"),
                                          .from = from == "raw"      ? From::raw
                                                  : from == "tracks" ? From::tracks
                                                                     : From::best,
                                          .set = values.texts("--set"),
                                          .json = values.has("--json")};
    return sandbox::confined(options.file.string(), sandbox::confinement_for(options.file),
                             [&] { return replay(options) ? manual::exit_ok : manual::exit_not_identical; });
}

}  // namespace

manual::Command replay_row() {
    return {
        .name = "replay",
        .summary = "Recompute a recording's results from its raw streams",
        .details =
            "Exit status 4 means that at least one number differs in at least one bit from the recorded one.",
        .arguments = arguments,
        .example = "shakerd replay --set from_s=3.5 run.nxs",
        .exit_statuses = {manual::exit_device, manual::exit_not_identical},
        .act = act};
}

}  // namespace shaker::command_line

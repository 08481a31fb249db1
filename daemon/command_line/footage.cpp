#include "daemon/command_line/rows.hpp"
#include "daemon/commands/footage_commands.hpp"

namespace shaker::command_line {

namespace {

using manual::Argument;
using manual::Kind;

constexpr std::array reduce_arguments{
    Argument{
        .name = "SESSION", .help = "session.toml: movies, accelerations and geometry", .kind = Kind::file},
    Argument{.name = "--output",
             .letter = 'o',
             .value = "FILE",
             .help = "Recording (HDF5) for \"shakerd replay\"",
             .kind = Kind::file,
             .otherwise = "none"},
    frames_argument, json_argument};

constexpr std::array track_arguments{
    Argument{.name = "SESSION",
             .help = "session.toml; drive and accelerometer are not needed",
             .kind = Kind::file},
    Argument{.name = "--output",
             .letter = 'o',
             .value = "FILE",
             .help = "CSV with the columns camera,frame,t_s,target,x_px,y_px,sd_px,x_mm,state",
             .kind = Kind::file,
             .otherwise = "a summary only"},
    json_argument};

int act_reduce(const manual::Values& values) {
    commands::ReduceOptions options{
        .session = values.text("SESSION"), .out = values.text("--output"), .json = values.has("--json")};
    options.pictures = recorded::kept_pictures_named(values.text("--frames")).value_or(options.pictures);
    reduce_session(options);
    return manual::exit_ok;
}

int act_track(const manual::Values& values) {
    commands::track_session(
        {.session = values.text("SESSION"), .out = values.text("--output"), .json = values.has("--json")});
    return manual::exit_ok;
}

}  // namespace

manual::Command reduce_row() {
    return {.name = "reduce",
            .summary = "Reduce a session of footage that shakerd did not record",
            .arguments = reduce_arguments,
            .example = "shakerd reduce session.toml -o session.nxs",
            .exit_statuses = {manual::exit_device},
            .act = act_reduce};
}

manual::Command track_row() {
    return {.name = "track",
            .summary = "Track the targets of a session without reducing it",
            .arguments = track_arguments,
            .example = "shakerd track session.toml -o tracks.csv",
            .exit_statuses = {manual::exit_device},
            .act = act_track};
}

}  // namespace shaker::command_line

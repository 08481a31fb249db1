#include <spdlog/spdlog.h>

#include "daemon/command_line/rows.hpp"
#include "daemon/commands/run_command.hpp"
#include "daemon/manual/values.hpp"

namespace shaker::command_line {

namespace {

using manual::Argument;
using manual::Kind;

constexpr auto arguments = manual::joined(
    std::array{
        rig_argument, scene_argument,
        Argument{.name = "--settings",
                 .value = "FILE",
                 .help = "TOML file with a table [run]; options on the command line replace its values",
                 .kind = Kind::file}},
    manual::drive_arguments(true),
    std::array{
        manual::argument_of(point_field("periods"), true), manual::argument_of(point_field("settle"), true),
        Argument{
            .name = "--mu",
            .value = "MU",
            .help =
                "Friction coefficient of walker and base: the run notes the predicted walk and the periods "
                "until the edge limit before it starts",
            .kind = Kind::quantity,
            .dimension = Dimension::ratio,
            .allowed = {0, 10},
            .otherwise = "the walk is not predicted"},
        Argument{.name = "--output",
                 .letter = 'o',
                 .value = "FILE",
                 .help = "Recording (HDF5)",
                 .kind = Kind::file,
                 .otherwise = "only trips are recorded"},
        Argument{
            .name = "--trips",
            .value = "FOLDER",
            .help = "Folder for trip-<UTC>.nxs, the last 2 s of a run without --output that a limit stopped",
            .kind = Kind::folder,
            .standard = ".",
            .must_exist = true},
        frames_argument,
        Argument{
            .name = "--no-identify",
            .help = "Use the response of the data sheet; do not identify the base's response before the run"},
        Argument{
            .name = "--uncommissioned",
            .help = "Drive a bench without a valid record of \"check --commission\", at half its limits"},
        Argument{.name = "--open-loop", .help = "Do not correct the drive by the measured motion"},
        Argument{.name = "--threads",
                 .help = "Run each loop in its own thread, as on hardware, instead of in lockstep"},
        Argument{.name = "--real-time", .help = "With --threads: run a simulated rig in real time"},
        json_argument});

int act(const manual::Values& values) {
    if (const std::string doubt = manual::doubtful_gamma(values); !doubt.empty()) spdlog::warn("{}", doubt);
    commands::run(run_options(values));
    return manual::exit_ok;
}

}  // namespace

run::RunOptions run_options(const manual::Values& values) {
    run::RunOptions options;
    if (values.has("--settings")) read_run_settings(values.text("--settings"), options);
    if (values.has("--rig")) options.rig = values.text("--rig");
    if (values.has("--scene")) options.scene = values.text("--scene");
    options.drive = changed_drive(values, options.drive);
    for (const MeasurementField& field : measurement_fields)
        if (field.lasts && values.has(field.option)) options.plan.*field.member = values.whole(field.option);
    if (values.has("--mu")) options.mu = {values.number("--mu"), 0};
    options.out = values.text("--output");
    options.trips = values.text("--trips");
    if (values.has("--frames"))
        options.pictures = recorded::kept_pictures_named(values.text("--frames")).value_or(options.pictures);
    if (values.has("--no-identify")) options.identify = false;
    if (values.has("--open-loop")) options.closed_loop = false;
    options.uncommissioned = values.has("--uncommissioned");
    options.threads = values.has("--threads");
    options.real_time = values.has("--real-time");
    options.json = values.has("--json");
    return options;
}

manual::Command run_row() {
    return {
        .name = "run",
        .summary = "Drive a rig, measure, track, reduce and record",
        .details =
            "The command identifies the response of the base, starts the drive softly, waits until base and "
            "walker have settled, measures, and prints the results.",
        .arguments = arguments,
        .example = "shakerd run --rig sim: --gamma 1.5g --phi 35deg --periods 40 -o run.nxs",
        .exit_statuses = {manual::exit_device, manual::exit_tripped, manual::exit_signal},
        .act = act};
}

}  // namespace shaker::command_line

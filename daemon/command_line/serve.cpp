#include "daemon/command_line/rows.hpp"
#include "daemon/commands/serve_command.hpp"

namespace shaker::command_line {

namespace {

using manual::Argument;
using manual::Kind;

constexpr Range ports{0, 65535};

constexpr std::array arguments{
    Argument{
        .name = "--settings",
        .value = "FILE",
        .help = "TOML file with the tables [serve] and [run]; options on the command line replace its values",
        .kind = Kind::file,
        .must_exist = true},
    Argument{.name = "--rig",
             .value = "RIG",
             .help = "Rig file (TOML) that names the devices, or sim: for the simulated bench",
             .kind = Kind::file,
             .otherwise = "as in the settings, else sim:"},
    scene_argument,
    Argument{.name = "--http-port",
             .value = "PORT",
             .help = "Port of page, metrics and streams; 0: any free port",
             .kind = Kind::whole,
             .allowed = ports,
             .otherwise = "as in the settings, else 8080"},
    Argument{.name = "--scpi-port",
             .value = "PORT",
             .help = "Port of the instrument language (SCPI); 0: any free port",
             .kind = Kind::whole,
             .allowed = ports,
             .otherwise = "as in the settings, else 5025"},
    Argument{.name = "--page",
             .value = "FOLDER",
             .help = "Folder of the page's files",
             .kind = Kind::folder,
             .otherwise = "as in the settings, else the program's own page",
             .must_exist = true},
    Argument{.name = "--recordings",
             .value = "FOLDER",
             .help = "Folder of the recordings",
             .kind = Kind::folder,
             .otherwise = "as in the settings, else .",
             .must_exist = true}};

int act(const manual::Values& values) {
    commands::ServeOptions options{.settings = values.text("--settings"),
                                   .rig = values.text("--rig"),
                                   .scene = values.text("--scene"),
                                   .page = values.text("--page"),
                                   .recordings = values.text("--recordings")};
    if (values.has("--http-port")) options.http_port = values.whole("--http-port");
    if (values.has("--scpi-port")) options.scpi_port = values.whole("--scpi-port");
    commands::serve(options);
    return manual::exit_ok;
}

}  // namespace

manual::Command serve_row() {
    return {.name = "serve",
            .summary = "Run the daemon: a bench on call with page and remote control",
            .details = "The daemon runs until SIGTERM or SIGINT. SIGHUP reads the settings again.",
            .arguments = arguments,
            .example = "shakerd serve --rig sim:",
            .exit_statuses = {manual::exit_device},
            .act = act};
}

}  // namespace shaker::command_line

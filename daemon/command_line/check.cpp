#include "daemon/command_line/rows.hpp"
#include "daemon/commands/check_command.hpp"

namespace shaker::command_line {

namespace {

using manual::Argument;
using manual::Kind;

constexpr std::array arguments{
    rig_argument,
    scene_argument,
    Argument{.name = "--frequency",
             .value = "FREQUENCY",
             .help = "Frequency of the first of two harmonics, e.g. 20Hz",
             .kind = Kind::quantity,
             .dimension = Dimension::frequency,
             .allowed = drive_limits.frequency,
             .standard = "20Hz"},
    Argument{.name = "--level",
             .value = "SHARE",
             .help = "Amplitude of each harmonic as a share of the DAC's full scale",
             .kind = Kind::quantity,
             .dimension = Dimension::ratio,
             .allowed = {0, 0.2},
             .standard = "0.02"},
    Argument{
        .name = "--commission",
        .help =
            "Then lead the operator through the first day: the record lets run and serve drive the bench"},
    json_argument};

int act(const manual::Values& values) {
    const bool sound = commands::check({.rig = values.text("--rig"),
                                        .scene = values.text("--scene"),
                                        .frequency_hz = values.number("--frequency"),
                                        .level = values.number("--level"),
                                        .json = values.has("--json"),
                                        .commission = values.has("--commission")});
    return sound ? manual::exit_ok : manual::exit_device;
}

}  // namespace

manual::Command check_row() {
    return {.name = "check",
            .summary = "Open every device of a rig and test it at low level",
            .details = "A device that fails the test also gives exit status 3.",
            .arguments = arguments,
            .example = "shakerd check --rig bench.toml",
            .exit_statuses = {manual::exit_device, manual::exit_tripped, manual::exit_signal},
            .act = act};
}

}  // namespace shaker::command_line

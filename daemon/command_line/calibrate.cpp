#include "calibration/accelerometer/normal_gravity.hpp"
#include "daemon/command_line/rows.hpp"
#include "daemon/commands/calibrate/calibrate_command.hpp"
#include "drivers/errors.hpp"

namespace shaker::command_line {

namespace {

using manual::Argument;
using manual::Kind;

constexpr std::array<std::string_view, 1> devices{"accelerometer"};

constexpr std::array arguments{
    Argument{.name = "DEVICE", .help = "What to calibrate", .kind = Kind::word, .words = devices},
    rig_argument,
    scene_argument,
    Argument{
        .name = "--from",
        .value = "FILE",
        .help =
            "Instead of a live sensor: CSV with the columns attitude,x,y,z (counts), one record or more each",
        .kind = Kind::file,
        .many = true},
    Argument{.name = "--g",
             .value = "ACCELERATION",
             .help = "Gravity of the place",
             .kind = Kind::quantity,
             .dimension = Dimension::acceleration,
             .allowed = {9.75, 9.85},
             .otherwise = "from --latitude and --height"},
    Argument{.name = "--g-error",
             .value = "ACCELERATION",
             .help = "Its standard error",
             .kind = Kind::quantity,
             .dimension = Dimension::acceleration,
             .allowed = {0, 0.01},
             .standard = "0m/s^2"},
    Argument{.name = "--latitude",
             .value = "ANGLE",
             .help = "Latitude of the place, north or south; the gravity that follows is right to 3e-4 m/s^2",
             .kind = Kind::quantity,
             .dimension = Dimension::angle,
             .allowed = {-1.5707964, 1.5707964}},
    Argument{.name = "--height",
             .value = "LENGTH",
             .help = "Its height above the sea",
             .kind = Kind::quantity,
             .dimension = Dimension::length,
             .allowed = {-500, 9000},
             .standard = "0m"},
    Argument{.name = "--hold",
             .value = "TIME",
             .help = "Time of rest that makes an attitude",
             .kind = Kind::quantity,
             .dimension = Dimension::time,
             .allowed = {0.5, 600},
             .standard = "2s"},
    Argument{.name = "--output",
             .letter = 'o',
             .value = "FILE",
             .help = "Calibration file; the records of a live sensor are kept beside it as CSV",
             .kind = Kind::file,
             .otherwise = "accelerometer-DATE.toml"},
    json_argument};

calibration::Estimate gravity(const manual::Values& values) {
    if (values.has("--g") == values.has("--latitude"))
        throw InputError{
            "calibrate accelerometer: the gain follows from the gravity of the place; expected either --g, "
            "for "
            "example 9.8123m/s^2, or --latitude and --height"};
    if (values.has("--g")) return {values.number("--g"), values.number("--g-error")};
    return calibration::normal_gravity(values.number("--latitude"), values.number("--height"));
}

int act(const manual::Values& values) {
    commands::CalibrateOptions options{.rig = values.text("--rig"),
                                       .scene = values.text("--scene"),
                                       .gravity = gravity(values),
                                       .hold_s = values.number("--hold"),
                                       .output = values.text("--output"),
                                       .json = values.has("--json")};
    for (const std::string& file : values.texts("--from")) options.from.emplace_back(file);
    commands::calibrate_accelerometer(options);
    return manual::exit_ok;
}

}  // namespace

manual::Command calibrate_row() {
    return {
        .name = "calibrate",
        .summary = "Calibrate a sensor of the bench and write its calibration file",
        .details =
            "accelerometer: turn the sensor by hand to the 18 attitudes that are asked for and hold it "
            "still in each; the magnitude of gravity gives gain matrix and offsets. Nothing is driven. The "
            "rig file names the result: [accelerometer] calibration = \"FILE\".",
        .arguments = arguments,
        .example = "shakerd calibrate accelerometer --rig bench.toml --latitude 52.1deg --height 80m",
        .exit_statuses = {manual::exit_device, manual::exit_signal},
        .act = act};
}

}  // namespace shaker::command_line

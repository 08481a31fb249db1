#include "daemon/commands/calibrate/calibrate.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cstdint>
#include <initializer_list>

#include "calibration/camera/printed_targets.hpp"
#include "daemon/manual/values.hpp"
#include "daemon/report/printing.hpp"
#include "drivers/optics/bar_code.hpp"

namespace shaker::commands {

namespace {

using manual::Argument;
using manual::Kind;

constexpr std::array<std::string_view, 4> calibrated_devices{"accelerometer", "response", "camera", "strip"};

constexpr Argument length_argument(std::string_view name, std::string_view help, Range allowed,
                                   std::string_view standard) {
    return {.name = name,
            .value = "LENGTH",
            .help = help,
            .kind = Kind::quantity,
            .dimension = Dimension::length,
            .allowed = allowed,
            .standard = standard};
}

constexpr Argument whole_argument(std::string_view name, std::string_view help, Range allowed,
                                  std::string_view standard) {
    return {.name = name,
            .value = "NUMBER",
            .help = help,
            .kind = Kind::whole,
            .allowed = allowed,
            .standard = standard};
}

constexpr std::array calibrate_arguments{
    Argument{
        .name = "DEVICE",
        .help = "What to calibrate; response: of the accelerometer over frequency; strip: print bars for the "
                "base",
        .kind = Kind::word,
        .words = calibrated_devices},
    manual::rig_argument,
    manual::scene_argument,
    Argument{.name = "--from",
             .value = "FILE",
             .help = "Instead of a live device: accelerometer: CSV with the columns attitude,x,y,z (counts), "
                     "one record or "
                     "more each; response: recordings, folders of campaigns, or a certificate (CSV with the "
                     "columns frequency_hz,gain,gain_error,phase_deg,phase_error_deg); camera: pictures of "
                     "the board on the base (PNG, TIFF, ...)",
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
             .help = "Time of rest that makes an attitude, or a picture of the board",
             .kind = Kind::quantity,
             .dimension = Dimension::time,
             .allowed = {0.5, 600},
             .standard = "2s"},
    Argument{.name = "--output",
             .letter = 'o',
             .value = "FILE",
             .help = "Calibration file; the records of a live accelerometer are kept beside it as CSV",
             .kind = Kind::file,
             .otherwise = "accelerometer-DATE.toml, response-DATE.toml, camera-NAME-DATE.toml, strip.pdf"},
    Argument{.name = "--coupled-dc",
             .help = "response: the sensor has no lower corner; only for certificates, recordings contain it"},
    Argument{.name = "--camera",
             .value = "NAME",
             .help = "camera: its name",
             .kind = Kind::text,
             .standard = "top"},
    Argument{.name = "--print",
             .value = "FILE",
             .help = "camera: write the board as a PDF of exact size, and do nothing else",
             .kind = Kind::file},
    length_argument("--square", "camera: side of the board's squares, as measured", {5e-4, 1}, "10mm"),
    length_argument("--marker", "camera: side of its markers", {2e-4, 1}, "7mm"),
    whole_argument("--columns", "camera: squares in a row of the board", {3, 100}, "17"),
    whole_argument("--rows", "camera: rows of squares", {3, 100}, "11"),
    Argument{.name = "--board-error",
             .value = "RATIO",
             .help = "camera: relative standard error of --square",
             .kind = Kind::quantity,
             .dimension = Dimension::ratio,
             .allowed = {1e-9, 0.1},
             .standard = "0.0002"},
    length_argument("--thickness", "camera: of the board; its face lies so high over the reference plane",
                    {0, 1}, "0mm"),
    Argument{.name = "--raised",
             .value = "FILE",
             .help = "camera: with --from: pictures of the board raised by --raised-by",
             .kind = Kind::file,
             .many = true},
    length_argument("--raised-by", "camera: height of the spacer under the raised board", {0, 10}, "0mm"),
    length_argument("--height-error", "camera: standard error of each height", {1e-9, 0.1}, "0.05mm"),
    length_argument("--walker-height", "camera: plane of the walker over the reference plane", {-1, 10},
                    "0mm"),
    length_argument("--distance", "camera: with --from: lens to the reference plane; 0: telecentric",
                    {0, 100}, "0mm"),
    Argument{.name = "--distance-error",
             .value = "RATIO",
             .help = "camera: relative standard error of --distance, or of the distance in the rig file",
             .kind = Kind::quantity,
             .dimension = Dimension::ratio,
             .allowed = {1e-9, 1},
             .standard = "0.1"},
    Argument{
        .name = "--axis",
        .help =
            "camera: +x is that of the settings, the board's x, or the line on which the board was pushed",
        .kind = Kind::word,
        .words = axis_words,
        .standard = "settings"},
    whole_argument("--pictures", "camera: live: pictures on the base; a third as many raised", {1, 100}, "9"),
    length_argument("--length", "camera: the quick way: a known length in the base's plane", {1e-3, 10}, ""),
    length_argument("--length-error", "camera: its standard error", {0, 1}, "0.1mm"),
    Argument{.name = "--ends",
             .value = "X,Y,X,Y",
             .help = "camera: its ends in the picture, px",
             .kind = Kind::text},
    Argument{.name = "--size",
             .value = "WIDTH,HEIGHT",
             .help = "camera: with --length: size of the picture, px",
             .kind = Kind::text},
    Argument{.name = "--corners",
             .value = "FILE",
             .help = "camera: write the corners and their residuals as CSV; plot_board.py draws them",
             .kind = Kind::file},
    length_argument("--strip-length", "strip: its length", {0.02, 3}, "200mm"),
    length_argument("--strip-height", "strip: its height", {1e-3, 1}, "12mm"),
    length_argument("--bar-least", "strip: least width of a bar", {1e-4, 0.1}, "3mm"),
    length_argument("--bar-most", "strip: greatest width of a bar", {1e-4, 0.1}, "8mm"),
    whole_argument("--seed", "strip: its bars follow from this number", {1, 1e9}, "1"),
    manual::json_argument};

// Refuses arguments that are neither `common` nor of this device by their help.
void refuse_others(std::string_view device, const manual::Values& values,
                   std::initializer_list<std::string_view> common) {
    for (const Argument& a : calibrate_arguments)
        if (values.has(a.name) && !a.help.starts_with(fmt::format("{}:", device)) &&
            std::ranges::find(common, a.name) == common.end())
            throw InputError{fmt::format("calibrate {}: {} is for another device", device, a.name)};
}

// Writes bars for the base as a PDF and prints how to check it. The file is not overwritten. InputError if
// the widths do not fit or the strip has too few edges for tracking.
void print_strip(const optics::BarCode& code, double height_mm, const std::filesystem::path& output) {
    constexpr std::size_t fewest_edges = 8;
    if (code.least_mm > code.most_mm)
        throw InputError{
            fmt::format("--bar-least {} mm: must be at most --bar-most, {} mm", code.least_mm, code.most_mm)};
    const std::size_t edges = optics::edges_of(code).size();
    if (edges < fewest_edges)
        throw InputError{
            fmt::format("--strip-length {} mm: has {} edges; tracking needs {} in view; narrower "
                        "bars or a longer strip have more",
                        code.length_mm, edges, fewest_edges)};
    NewFile{output}.append(calibration::strip_pdf(code, height_mm));
    report::say(
        fmt::format("written: {}; print at 100 % and measure the line under the strip\n"
                    "{} edges; bars of {:g} to {:g} mm; in the picture a bar should be 6 px or wider\n"
                    "for the table of the target: kind = \"code\"\n",
                    output.string(), edges, code.least_mm, code.most_mm));
}

int act_on_strip(const manual::Values& values) {
    refuse_others("strip", values, {"DEVICE", "--output"});
    const auto mm = [&](std::string_view name) { return 1e3 * values.number(name); };
    const std::string output = values.text("--output");
    print_strip({.seed = static_cast<std::uint64_t>(values.whole("--seed")),
                 .length_mm = mm("--strip-length"),
                 .least_mm = mm("--bar-least"),
                 .most_mm = mm("--bar-most")},
                mm("--strip-height"), output.empty() ? "strip.pdf" : output);
    return manual::exit_ok;
}

int act_on_calibrate(const manual::Values& values) {
    const std::string device = values.text("DEVICE");
    if (device == "strip") return act_on_strip(values);
    if (device == "response") {
        refuse_others("response", values, {"DEVICE", "--from", "--output", "--json"});
        calibrate_response(values);
        return manual::exit_ok;
    }
    if (device == "camera") {
        calibrate_camera(values);
        return manual::exit_ok;
    }
    for (const Argument& a : calibrate_arguments)
        if ((a.help.starts_with("camera:") || a.help.starts_with("response:")) && values.has(a.name))
            throw InputError{fmt::format("calibrate accelerometer: {} is for another device", a.name)};
    calibrate_accelerometer(values);
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
            "rig file names the result: [accelerometer] calibration = \"FILE\". camera: print the board "
            "(--print), lay "
            "it on the base in several places and turned, then raised by a known height; scale, tilt, "
            "distance "
            "and lens follow from the corners of its squares. The rig file names the result in the camera's "
            "table. response: lower corner and low-pass of the accelerometer from what its cameras saw at "
            "the "
            "same time: drive the lines of the plan response.toml with \"shakerd campaign\", then give its "
            "folder. The rig file names the result: [accelerometer] response = \"FILE\". strip: prints bars "
            "of irregular width as a PDF, for a target of kind \"code\".",
        .arguments = calibrate_arguments,
        .example = "shakerd calibrate accelerometer --rig bench.toml --latitude 52.1deg --height 80m",
        .exit_statuses = {manual::exit_device, manual::exit_signal},
        .act = act_on_calibrate};
}

}  // namespace shaker::commands

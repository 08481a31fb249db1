#include "daemon/commands/calibrate/calibrate.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cstdint>

#include "calibration/camera/printed_targets.hpp"
#include "daemon/report/printing.hpp"
#include "drivers/optics/bar_code.hpp"

namespace shaker::commands {

namespace {

using manual::Argument;
using manual::Kind;

constexpr std::array<std::string_view, 4> calibrated_devices{"accelerometer", "response", "camera", "strip"};

constexpr Argument length_option(std::string_view name, Range allowed, std::string_view help,
                                 std::string_view standard = {}) {
    return manual::quantity_option(name, "LENGTH", Dimension::length, allowed, help, standard);
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
    manual::quantity_option("--g", "ACCELERATION", Dimension::acceleration, {9.75, 9.85},
                            "Gravity of the place", {}, "from --latitude and --height"),
    manual::quantity_option("--g-error", "ACCELERATION", Dimension::acceleration, {0, 0.01},
                            "Its standard error", "0m/s^2"),
    manual::quantity_option(
        "--latitude", "ANGLE", Dimension::angle, {-1.5707964, 1.5707964},
        "Latitude of the place, north or south; the gravity that follows is right to 3e-4 m/s^2"),
    length_option("--height", {-500, 9000}, "Its height above the sea", "0m"),
    manual::quantity_option("--hold", "TIME", Dimension::time, {0.5, 600},
                            "Time of rest that makes an attitude, or a picture of the board", "2s"),
    Argument{.name = "--output",
             .letter = 'o',
             .value = "FILE",
             .help = "Calibration file; the records of a live accelerometer are kept beside it as CSV",
             .kind = Kind::file,
             .otherwise = "accelerometer-DATE.toml, response-DATE.toml, camera-NAME-DATE.toml, strip.pdf"},
    Argument{
        .name = "--coupled-dc",
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
    length_option("--square", {5e-4, 1}, "camera: side of the board's squares, as measured", "10mm"),
    length_option("--marker", {2e-4, 1}, "camera: side of its markers", "7mm"),
    manual::whole_option("--columns", "NUMBER", {3, 100}, "camera: squares in a row of the board", "17"),
    manual::whole_option("--rows", "NUMBER", {3, 100}, "camera: rows of squares", "11"),
    manual::quantity_option("--board-error", "RATIO", Dimension::ratio, {1e-9, 0.1},
                            "camera: relative standard error of --square", "0.0002"),
    length_option("--thickness", {0, 1},
                  "camera: of the board; its face lies so high over the reference plane", "0mm"),
    Argument{.name = "--raised",
             .value = "FILE",
             .help = "camera: with --from: pictures of the board raised by --raised-by",
             .kind = Kind::file,
             .many = true},
    length_option("--raised-by", {0, 10}, "camera: height of the spacer under the raised board", "0mm"),
    length_option("--height-error", {1e-9, 0.1}, "camera: standard error of each height", "0.05mm"),
    length_option("--walker-height", {-1, 10}, "camera: plane of the walker over the reference plane", "0mm"),
    length_option("--distance", {0, 100}, "camera: with --from: lens to the reference plane; 0: telecentric",
                  "0mm"),
    manual::quantity_option(
        "--distance-error", "RATIO", Dimension::ratio, {1e-9, 1},
        "camera: relative standard error of --distance, or of the distance in the rig file", "0.1"),
    Argument{
        .name = "--axis",
        .help =
            "camera: +x is that of the settings, the board's x, or the line on which the board was pushed",
        .kind = Kind::word,
        .words = axis_words,
        .standard = "settings"},
    manual::whole_option("--pictures", "NUMBER", {1, 100},
                         "camera: live: pictures on the base; a third as many raised", "9"),
    length_option("--length", {1e-3, 10}, "camera: the quick way: a known length in the base's plane"),
    length_option("--length-error", {0, 1}, "camera: its standard error", "0.1mm"),
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
    length_option("--strip-length", {0.02, 3}, "strip: its length", "200mm"),
    length_option("--strip-height", {1e-3, 1}, "strip: its height", "12mm"),
    length_option("--bar-least", {1e-4, 0.1}, "strip: least width of a bar", "3mm"),
    length_option("--bar-most", {1e-4, 0.1}, "strip: greatest width of a bar", "8mm"),
    manual::whole_option("--seed", "NUMBER", {1, 1e9}, "strip: its bars follow from this number", "1"),
    manual::json_argument};

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

}  // namespace

void refuse_others(std::string_view device, const manual::Values& values,
                   std::initializer_list<std::string_view> common) {
    for (const Argument& a : calibrate_arguments)
        if (values.has(a.name) && !a.help.starts_with(fmt::format("{}:", device)) &&
            std::ranges::find(common, a.name) == common.end())
            throw InputError{fmt::format("calibrate {}: {} is for another device", device, a.name)};
}

int calibrate(const manual::Values& values) {
    const std::string device = values.text("DEVICE");
    if (device == "strip") return act_on_strip(values);
    if (device == "response") {
        refuse_others("response", values, {"DEVICE", "--from", "--output", "--json"});
        const std::vector<std::string> from = values.texts("--from");
        if (from.empty())
            throw InputError{"calibrate response: --coupled-dc is for a certificate; name it by --from"};
        calibrate_response(values, response_file(values), {from.begin(), from.end()});
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

manual::Command calibrations_row() {
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
            "table. response: lower corner and low-pass of the accelerometer: two drives of eight lines "
            "each, 5 to 200 Hz and at most 1 g, which the cameras see at the same time, 65 s, as a campaign: "
            "a "
            "trip pauses it. The recordings stay in a folder beside the file. With --from nothing is driven. "
            "The rig file names "
            "the result: [accelerometer] response = \"FILE\". strip: prints bars "
            "of irregular width as a PDF, for a target of kind \"code\".",
        .arguments = calibrate_arguments,
        .example = "shakerd calibrate accelerometer --rig bench.toml --latitude 52.1deg --height 80m",
        .exit_statuses = {manual::exit_device, manual::exit_tripped, manual::exit_signal},
        .act = calibrate};
}

}  // namespace shaker::commands

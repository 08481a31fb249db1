#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <charconv>

#include "calibration/accelerometer/tumble.hpp"
#include "daemon/command_line/rows.hpp"
#include "daemon/commands/calibrate/calibrate_command.hpp"
#include "daemon/commands/calibrate/camera_command.hpp"
#include "daemon/commands/calibrate/strip_command.hpp"
#include "drivers/errors.hpp"

namespace shaker::command_line {

namespace {

using manual::Argument;
using manual::Kind;

constexpr std::array<std::string_view, 3> devices{"accelerometer", "camera", "strip"};
constexpr std::array<std::string_view, 3> axes{"settings", "board", "slid"};

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

constexpr std::array arguments{
    Argument{.name = "DEVICE",
             .help = "What to calibrate; strip: print bars for the base",
             .kind = Kind::word,
             .words = devices},
    rig_argument,
    scene_argument,
    Argument{.name = "--from",
             .value = "FILE",
             .help = "Instead of a live device: accelerometer: CSV with the columns attitude,x,y,z (counts), "
                     "one record or "
                     "more each; camera: pictures of the board on the base (PNG, TIFF, ...)",
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
             .otherwise = "accelerometer-DATE.toml, camera-NAME-DATE.toml, strip.pdf"},
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
        .words = axes,
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
    json_argument};

// Options of one device only.
constexpr std::array<std::string_view, 4> of_accelerometer{"--g", "--g-error", "--latitude", "--height"};

calibration::Estimate gravity(const manual::Values& values) {
    if (values.has("--g") == values.has("--latitude"))
        throw InputError{
            "calibrate accelerometer: the gain follows from the gravity of the place; expected either --g, "
            "for "
            "example 9.8123m/s^2, or --latitude and --height"};
    if (values.has("--g")) return {values.number("--g"), values.number("--g-error")};
    return calibration::normal_gravity(values.number("--latitude"), values.number("--height"));
}

// The numbers of a text with commas.
template <std::size_t count>
std::array<double, count> numbers_of(const manual::Values& values, std::string_view name) {
    std::array<double, count> numbers{};
    const std::string text = values.text(name);
    const char* at = text.data();
    const char* const end = at + text.size();
    for (std::size_t k = 0; k < count; ++k) {
        const auto [next, error] = std::from_chars(at, end, numbers[k]);
        const bool last = k + 1 == count;
        if (error != std::errc{} || (last ? next != end : next == end || *next != ','))
            throw InputError{fmt::format("{} \"{}\": expected {} numbers with commas", name, text, count)};
        at = next + 1;
    }
    return numbers;
}

commands::KnownLength known_length(const manual::Values& values) {
    if (!values.has("--ends") || !values.has("--size"))
        throw InputError{"--length: needs --ends X,Y,X,Y and --size WIDTH,HEIGHT, in px of the picture"};
    const auto size = numbers_of<2>(values, "--size");
    for (const double px : size) require_allowed("--size", px, {1, 65536}, "px");
    return {.length_mm = 1e3 * values.number("--length"),
            .error_mm = 1e3 * values.number("--length-error"),
            .ends_px = numbers_of<4>(values, "--ends"),
            .size_px = {static_cast<int>(size[0]), static_cast<int>(size[1])}};
}

void require_camera_options(const manual::Values& values) {
    for (const std::string_view name : of_accelerometer)
        if (values.has(name))
            throw InputError{fmt::format("calibrate camera: {} is for the accelerometer", name)};
    const bool files = values.has("--from");
    if (files && !values.has("--distance"))
        throw InputError{
            "calibrate camera --from: expected --distance, from the lens to the base's plane (0mm: "
            "telecentric lens)"};
    if (values.has("--raised") && !(files && values.number("--raised-by") > 0))
        throw InputError{"--raised: needs --from with the pictures on the base, and --raised-by"};
}

int act_camera(const manual::Values& values) {
    require_camera_options(values);
    const auto mm = [&](std::string_view name) { return 1e3 * values.number(name); };
    commands::CameraOptions options;
    options.board = {.board = {.columns = values.whole("--columns"),
                               .rows = values.whole("--rows"),
                               .square_mm = mm("--square"),
                               .marker_mm = mm("--marker")},
                     .thickness_mm = mm("--thickness"),
                     .raised_mm = mm("--raised-by")};
    options.print = values.text("--print");
    for (const std::string& file : values.texts("--from")) options.from.emplace_back(file);
    for (const std::string& file : values.texts("--raised")) options.raised.emplace_back(file);
    if (values.has("--length")) options.length = known_length(values);
    const int pictures = values.whole("--pictures");
    options.lead = {.rig = values.text("--rig"),
                    .scene = values.text("--scene"),
                    .camera = values.text("--camera"),
                    .pictures = pictures,
                    .raised_pictures = std::max(1, pictures / 3),
                    .hold_s = values.number("--hold")};
    options.distance_mm = mm("--distance");
    options.distance_error = values.number("--distance-error");
    options.board_error = values.number("--board-error");
    options.offset_error_mm = mm("--height-error");
    options.walker_mm = mm("--walker-height");
    const auto axis = std::ranges::find(axes, values.text("--axis"));
    options.axis = static_cast<calibration::AxisFrom>(axis - axes.begin());
    options.output = values.text("--output");
    options.corners = values.text("--corners");
    options.json = values.has("--json");
    commands::calibrate_camera(options);
    return manual::exit_ok;
}

int act_strip(const manual::Values& values) {
    for (const Argument& a : arguments) {
        const bool known = a.help.starts_with("strip:") || a.name == "DEVICE" || a.name == "--output";
        if (!known && values.has(a.name))
            throw InputError{fmt::format("calibrate strip: {} is for a sensor", a.name)};
    }
    const auto mm = [&](std::string_view name) { return 1e3 * values.number(name); };
    const std::string output = values.text("--output");
    commands::print_strip({.seed = static_cast<std::uint64_t>(values.whole("--seed")),
                           .length_mm = mm("--strip-length"),
                           .least_mm = mm("--bar-least"),
                           .most_mm = mm("--bar-most")},
                          mm("--strip-height"), output.empty() ? "strip.pdf" : output);
    return manual::exit_ok;
}

int act(const manual::Values& values) {
    if (values.text("DEVICE") == "strip") return act_strip(values);
    if (values.text("DEVICE") == "camera") return act_camera(values);
    for (const Argument& a : arguments)
        if (a.help.starts_with("camera:") && values.has(a.name))
            throw InputError{fmt::format("calibrate accelerometer: {} is for a camera", a.name)};
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
            "rig file names the result: [accelerometer] calibration = \"FILE\". camera: print the board "
            "(--print), lay "
            "it on the base in several places and turned, then raised by a known height; scale, tilt, "
            "distance "
            "and lens follow from the corners of its squares. The rig file names the result in the camera's "
            "table. strip: prints bars of irregular width as a PDF, for a target of kind \"code\".",
        .arguments = arguments,
        .example = "shakerd calibrate accelerometer --rig bench.toml --latitude 52.1deg --height 80m",
        .exit_statuses = {manual::exit_device, manual::exit_signal},
        .act = act};
}

}  // namespace shaker::command_line

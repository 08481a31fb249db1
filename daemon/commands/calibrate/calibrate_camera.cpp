#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calibration/camera/camera_file.hpp"
#include "calibration/camera/printed_targets.hpp"
#include "daemon/commands/calibrate/board_pictures.hpp"
#include "daemon/commands/calibrate/calibrate.hpp"
#include "daemon/recording/time_text.hpp"
#include "daemon/report/printing.hpp"
#include "drivers/errors.hpp"

namespace shaker::commands {

namespace {

using calibration::CameraCalibration;
using calibration::PlacedBoard;
using calibration::PlaneFit;

// The quick way: two points of the picture whose distance is known.
struct KnownLength {
    double length_mm = 0, error_mm = 0;
    std::array<double, 4> ends_px{};  // x, y of either
    double ends_error_px = 0.5;
    std::array<int, 2> size_px{};  // of the picture
};

double mm(const manual::Values& values, std::string_view name) { return 1e3 * values.number(name); }

// Options of one device only.
constexpr std::array<std::string_view, 4> of_accelerometer{"--g", "--g-error", "--latitude", "--height"};

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

KnownLength known_length(const manual::Values& values) {
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

// The sizes of the board as given.
BoardOptions board_options(const manual::Values& values) {
    return {.board = {.columns = values.whole("--columns"),
                      .rows = values.whole("--rows"),
                      .square_mm = mm(values, "--square"),
                      .marker_mm = mm(values, "--marker")},
            .thickness_mm = mm(values, "--thickness"),
            .raised_mm = mm(values, "--raised-by")};
}

calibration::AxisFrom axis_from(const manual::Values& values) {
    const auto word = std::ranges::find(axis_words, values.text("--axis"));
    return static_cast<calibration::AxisFrom>(word - axis_words.begin());
}

std::string plane_text(const PlaneFit& f, const std::vector<PlacedBoard>& boards) {
    std::string text = fmt::format(
        "{} corners in {} pictures, rms {:.4f} px; they cover {:.0f} % x {:.0f} % of the picture\n",
        f.corners, boards.size(), f.rms_px, 100 * f.coverage[0], 100 * f.coverage[1]);
    text += fmt::format(
        "scale       {:.7g} mm/px, error {:.2g} % in the base's plane, {:.2g} % in the walker's\n",
        f.view.mm_per_px, 100 * f.base_error, 100 * f.walker_error);
    const auto line = [&](std::string_view name, const calibration::Estimate& e, std::string_view unit) {
        text += fmt::format("{:<11} {:.6g} +- {:.2g} {}\n", name, e.value, e.sigma, unit);
    };
    if (f.view.distance_mm > 0)
        line("distance", f.distance_mm, f.distance_found ? "mm" : "mm (of the settings)");
    line("tilt x", f.tilt_x_deg, "deg");
    line("tilt y", f.tilt_y_deg, "deg");
    line("lens k1", f.k1, "");
    line("lens k2", f.k2, "");
    line("centre x", f.centre_x_px, "px");
    line("centre y", f.centre_y_px, "px");
    text += fmt::format("+x in the picture: [{:.6f}, {:.6f}], {:.3f} +- {:.2g} deg from the board's x\n",
                        f.view.along[0], f.view.along[1], f.axis_deg.value, f.axis_deg.sigma);
    for (const std::string& finding : f.findings) text += "note: " + finding + "\n";
    return text;
}

nlohmann::json camera_json(const CameraCalibration& c, const std::string& file) {
    return {{"camera", c.camera},
            {"how", c.how},
            {"mm_per_px", c.mm_per_px},
            {"scale_error", c.scale_error},
            {"distance_mm", c.distance_mm},
            {"along", c.along},
            {"tilt_deg", c.tilt_deg},
            {"k1", c.lens.k1},
            {"k2", c.lens.k2},
            {"centre_px", c.lens.centre_px},
            {"focal_px", c.lens.focal_px},
            {"rms_px", c.rms_px},
            {"pictures", c.pictures},
            {"corners", c.corners},
            {"findings", c.findings},
            {"file", file}};
}

CameraCalibration by_length(const KnownLength& known) {
    const double dx = known.ends_px[2] - known.ends_px[0], dy = known.ends_px[3] - known.ends_px[1];
    const double length_px = std::hypot(dx, dy);
    constexpr double least_px = 20;
    if (!(length_px >= least_px))
        throw InputError{fmt::format("--ends: the points are {:.3g} px apart; at least {:.0f} px are needed",
                                     length_px, least_px)};
    CameraCalibration c{.date = {}, .camera = {}, .size_px = known.size_px, .how = "length"};
    c.mm_per_px = known.length_mm / length_px;
    c.scale_error =
        std::hypot(known.error_mm / known.length_mm, std::sqrt(2.0) * known.ends_error_px / length_px);
    c.pictures = 1;
    c.corners = 2;
    c.findings = {"a length gives the scale where it lies: distortion, tilt and distance are not determined"};
    return c;
}

CameraCalibration by_board(const PlaneFit& fit, const std::vector<PlacedBoard>& boards) {
    CameraCalibration c{.date = {},
                        .camera = {},
                        .size_px = {boards.front().seen.width, boards.front().seen.height},
                        .how = "board"};
    c.mm_per_px = fit.view.mm_per_px;
    c.scale_error = fit.view.scale_error;
    c.distance_mm = fit.view.distance_mm;
    c.along = fit.view.along;
    c.tilt_deg = fit.view.tilt_deg;
    c.lens = fit.view.lens;
    c.rms_px = fit.rms_px;
    c.pictures = static_cast<int>(boards.size());
    c.corners = fit.corners;
    c.findings = fit.findings;
    return c;
}

BoardPictures pictures_of(const manual::Values& values, const BoardOptions& board,
                          const std::function<void(const std::string&)>& show) {
    const std::vector<std::string> from = values.texts("--from"), raised = values.texts("--raised");
    if (from.empty()) return lead_board(values, board, show);
    BoardPictures pictures;
    pictures.view.distance_mm = mm(values, "--distance");
    pictures.boards = boards_in(from, board, 0);
    for (PlacedBoard& placed : boards_in(raised, board, board.raised_mm))
        pictures.boards.push_back(std::move(placed));
    return pictures;
}

// Height of the walker's plane; live: the highest of the view's targets.
double walker_offset(const manual::Values& values, double raised_mm, const View& view) {
    if (const double given_mm = mm(values, "--walker-height"); given_mm != 0) return given_mm;
    for (const Target& target : view.targets)
        if (target.name == "walker") return target.offset_mm;
    return raised_mm;
}

std::string corner_table(const PlaneFit& fit, const std::vector<PlacedBoard>& boards) {
    std::string text = fmt::format("# width_px = {}, height_px = {}\n", boards.front().seen.width,
                                   boards.front().seen.height);
    text += "picture,name,x_px,y_px,off_x_px,off_y_px,used\n";
    for (const calibration::CornerResidual& r : fit.residuals) {
        std::string name = boards[r.picture].seen.name;
        std::ranges::replace(name, ',', ' ');
        text += fmt::format("{},{},{:.4f},{:.4f},{:.5f},{:.5f},{}\n", r.picture + 1, name, r.at_px[0],
                            r.at_px[1], r.off_px[0], r.off_px[1], r.used ? 1 : 0);
    }
    return text;
}

void finish(CameraCalibration c, const manual::Values& values, const std::string& date, NewFile& file) {
    c.date = date;
    c.camera = values.text("--camera");
    file.append(calibration::calibration_text(c));
    if (values.has("--json")) {
        report::say(report::json_text(camera_json(c, file.name())) + "\n");
        return;
    }
    report::say(fmt::format(
        "written: {0}\nfor the rig file, in the table [[camera]] of \"{1}\": calibration = \"{0}\"\n",
        file.name(), c.camera));
}

}  // namespace

void calibrate_camera(const manual::Values& values) {
    require_camera_options(values);
    const BoardOptions given = board_options(values);
    const optics::Board& board = given.board;
    std::optional<KnownLength> length;
    if (values.has("--length")) length = known_length(values);
    const std::string print = values.text("--print"), output = values.text("--output"),
                      corner_file = values.text("--corners");
    const bool json = values.has("--json");
    if (!board.fits())
        throw InputError{fmt::format("--columns {} --rows {}: need {} markers; {} are known", board.columns,
                                     board.rows, board.columns * board.rows / 2, optics::markers)};
    if (!(board.marker_mm < board.square_mm))
        throw InputError{fmt::format("--marker {} mm: must be less than --square, {} mm", board.marker_mm,
                                     board.square_mm)};
    if (!print.empty()) {
        NewFile{print}.append(calibration::board_pdf(board));
        report::say(fmt::format("written: {}; print at 100 % and measure {:g} mm over {} squares\n", print,
                                board.columns * board.square_mm, board.columns));
        return;
    }
    const std::string date = recording::local_time_text();
    NewFile file{output.empty() ? std::filesystem::path{fmt::format(
                                      "camera-{}-{}.toml", values.text("--camera"), date.substr(0, 10))}
                                : std::filesystem::path{output}};
    if (length) {
        const CameraCalibration c = by_length(*length);
        if (!json)
            report::say(fmt::format("scale       {:.6g} mm/px +- {:.2g} %\nnote: {}\n", c.mm_per_px,
                                    100 * c.scale_error, c.findings.front()));
        finish(c, values, date, file);
        return;
    }
    std::optional<NewFile> corners;
    if (!corner_file.empty()) corners.emplace(corner_file);
    const auto show = [&](const std::string& line) {
        if (!json) report::say(line);
        std::fflush(stdout);
    };
    const BoardPictures pictures = pictures_of(values, given, show);
    const PlaneFit fit =
        calibration::fit_plane(pictures.boards, board,
                               {.settings = pictures.view,
                                .distance_error = values.number("--distance-error"),
                                .board_error = values.number("--board-error"),
                                .offset_error_mm = mm(values, "--height-error"),
                                .walker_offset_mm = walker_offset(values, given.raised_mm, pictures.view),
                                .axis = axis_from(values)});
    if (corners) corners->append(corner_table(fit, pictures.boards));
    if (!json) report::say(plane_text(fit, pictures.boards));
    finish(by_board(fit, pictures.boards), values, date, file);
}

}  // namespace shaker::commands

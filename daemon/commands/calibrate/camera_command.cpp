#include "daemon/commands/calibrate/camera_command.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "calibration/camera/camera_file.hpp"
#include "calibration/camera/printed_targets.hpp"
#include "daemon/commands/calibrate/new_file.hpp"
#include "daemon/recording/time_text.hpp"
#include "daemon/report/printing.hpp"
#include "drivers/errors.hpp"

namespace shaker::commands {

namespace {

using calibration::CameraCalibration;
using calibration::PlacedBoard;
using calibration::PlaneFit;

std::string text_of(const PlaneFit& f, const std::vector<PlacedBoard>& boards) {
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

nlohmann::json json_of(const CameraCalibration& c, const std::string& file) {
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

BoardPictures pictures_of(const CameraOptions& options, const std::function<void(const std::string&)>& show) {
    if (options.from.empty()) return lead_board(options.lead, options.board, show);
    BoardPictures pictures;
    pictures.view.distance_mm = options.distance_mm;
    pictures.boards = boards_in(options.from, options.board, 0);
    for (PlacedBoard& board : boards_in(options.raised, options.board, options.board.raised_mm))
        pictures.boards.push_back(std::move(board));
    return pictures;
}

double walker_offset(const CameraOptions& options, const View& view) {
    if (options.walker_mm != 0) return options.walker_mm;
    for (const Target& target : view.targets)
        if (target.name == "walker") return target.offset_mm;
    return options.board.raised_mm;
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

void finish(CameraCalibration c, const CameraOptions& options, const std::string& date, NewFile& file) {
    c.date = date;
    c.camera = options.lead.camera;
    file.append(calibration::calibration_text(c));
    if (options.json) {
        report::say(report::json_text(json_of(c, file.name())) + "\n");
        return;
    }
    report::say(fmt::format(
        "written: {0}\nfor the rig file, in the table [[camera]] of \"{1}\": calibration = \"{0}\"\n",
        file.name(), c.camera));
}

}  // namespace

void calibrate_camera(const CameraOptions& options) {
    if (!options.board.board.fits())
        throw InputError{fmt::format("--columns {} --rows {}: need {} markers; {} are known",
                                     options.board.board.columns, options.board.board.rows,
                                     options.board.board.columns * options.board.board.rows / 2,
                                     optics::markers)};
    if (!(options.board.board.marker_mm < options.board.board.square_mm))
        throw InputError{fmt::format("--marker {} mm: must be less than --square, {} mm",
                                     options.board.board.marker_mm, options.board.board.square_mm)};
    if (!options.print.empty()) {
        NewFile{options.print}.append(calibration::board_pdf(options.board.board));
        report::say(fmt::format(
            "written: {}; print at 100 % and measure {:g} mm over {} squares\n", options.print.string(),
            options.board.board.columns * options.board.board.square_mm, options.board.board.columns));
        return;
    }
    const std::string date = recording::local_time_text();
    NewFile file{options.output.empty() ? std::filesystem::path{fmt::format(
                                              "camera-{}-{}.toml", options.lead.camera, date.substr(0, 10))}
                                        : options.output};
    if (options.length) {
        const CameraCalibration c = by_length(*options.length);
        if (!options.json)
            report::say(fmt::format("scale       {:.6g} mm/px +- {:.2g} %\nnote: {}\n", c.mm_per_px,
                                    100 * c.scale_error, c.findings.front()));
        finish(c, options, date, file);
        return;
    }
    std::optional<NewFile> corners;
    if (!options.corners.empty()) corners.emplace(options.corners);
    const auto show = [&](const std::string& line) {
        if (!options.json) report::say(line);
        std::fflush(stdout);
    };
    const BoardPictures pictures = pictures_of(options, show);
    const PlaneFit fit = calibration::fit_plane(pictures.boards, options.board.board,
                                                {.settings = pictures.view,
                                                 .distance_error = options.distance_error,
                                                 .board_error = options.board_error,
                                                 .offset_error_mm = options.offset_error_mm,
                                                 .walker_offset_mm = walker_offset(options, pictures.view),
                                                 .axis = options.axis});
    if (corners) corners->append(corner_table(fit, pictures.boards));
    if (!options.json) report::say(text_of(fit, pictures.boards));
    finish(by_board(fit, pictures.boards), options, date, file);
}

}  // namespace shaker::commands

#include "calibration/camera/plane_fit.hpp"

#include <spdlog/fmt/fmt.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "calibration/camera/camera_scale.hpp"
#include "calibration/camera/plane_model.hpp"
#include "drivers/errors.hpp"

namespace shaker::calibration {

namespace {

using Eigen::MatrixXd, Eigen::VectorXd;
constexpr int least_corners = 30;
constexpr double least_coverage = 0.5, worst_scale_error = 5e-3, degree = std::numbers::pi / 180;

// Levenberg-Marquardt with the noise given.
void minimise(const PlaneModel& model, VectorXd& x, double noise_px) {
    constexpr int most_steps = 60;
    double damping = 1e-4;
    PlaneModel::Normal now = model.normal(x, noise_px);
    for (int i = 0; i < most_steps && damping < 1e12; ++i) {
        const VectorXd root = now.matrix.diagonal().cwiseSqrt().cwiseInverse();  // balances the unknowns
        MatrixXd damped = root.asDiagonal() * now.matrix * root.asDiagonal();
        damped.diagonal().array() += damping;
        const VectorXd move = root.asDiagonal() * damped.ldlt().solve(root.asDiagonal() * now.gradient);
        const double then = model.cost(x + move, noise_px);
        if (!(then <= now.cost)) {
            damping *= 10;
            continue;
        }
        const double gain = now.cost - then;
        x += move;
        damping = std::max(1e-9, 0.1 * damping);
        now = model.normal(x, noise_px);
        if (gain < 1e-7 * (1 + now.cost * 1e-3)) break;
    }
}

double noise_of(const PlaneModel::Normal& normal, Eigen::Index unknowns) {
    return std::sqrt(normal.squares_px / std::max(1.0, static_cast<double>(normal.count - unknowns)));
}

// Leaves out corners that are more than six standard deviations off; the number of them.
int reject(PlaneModel& model, const VectorXd& x) {
    constexpr double most_sigma = 6, least_px = 0.02, sigma_of_median = 1.1774;  // Rayleigh
    std::vector<double> off;
    for (const auto& o : model.observations) off.push_back(model.residual(x, o).norm());
    std::vector<double> sorted = off;
    const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
    std::ranges::nth_element(sorted, middle);
    const double limit = std::max(most_sigma * *middle / sigma_of_median, least_px);
    int out = 0;
    for (std::size_t i = 0; i < off.size(); ++i) {
        model.observations[i].used = off[i] <= limit;
        out += off[i] <= limit ? 0 : 1;
    }
    return out;
}

// Standard error of f(x) by the covariance.
template <class F>
double error_of(const VectorXd& x, const MatrixXd& covariance, F&& f) {
    VectorXd slope = VectorXd::Zero(x.size());
    for (int k = 0; k < PlaneModel::camera_unknowns; ++k) {
        const double h = 1e-5 * std::max(1.0, std::abs(x[k]));
        VectorXd up = x, down = x;
        up[k] += h;
        down[k] -= h;
        slope[k] = (f(up) - f(down)) / (2 * h);
    }
    return std::sqrt(std::max(0.0, slope.dot(covariance * slope)));
}

void require_corners(std::span<const PlacedBoard> pictures) {
    if (pictures.empty())
        throw InputError{"calibrate camera: no picture; expected at least one of the board"};
    std::size_t corners = 0;
    for (const PlacedBoard& p : pictures) {
        corners += p.seen.corners.size();
        const SeenBoard &first = pictures.front().seen, &seen = p.seen;
        if (seen.width != first.width || seen.height != first.height)
            throw InputError{
                fmt::format("{}: has {} x {} px, but {} has {} x {} px; all pictures must have the "
                            "size of the runs",
                            seen.name, seen.width, seen.height, first.name, first.width, first.height)};
        if (seen.corners.size() < 4)
            throw InputError{
                fmt::format("{}: {} corners of the board found ({} markers); at least 4 are needed: check "
                            "light, focus, and "
                            "the board's columns, rows, square and marker against those that were printed",
                            seen.name, seen.corners.size(), seen.markers)};
    }
    if (corners < least_corners)
        throw InputError{
            fmt::format("calibrate camera: {} corners in {} pictures; at least {} are needed: add "
                        "pictures, or print smaller squares",
                        corners, pictures.size(), least_corners)};
}

void require_coverage(PlaneFit& fit, std::span<const PlacedBoard> pictures) {
    const SeenBoard& first = pictures.front().seen;
    std::array<double, 2> least{1e9, 1e9}, most{-1e9, -1e9};
    for (const PlacedBoard& p : pictures)
        for (const SeenCorner& c : p.seen.corners)
            for (std::size_t k = 0; k < 2; ++k) {
                least[k] = std::min(least[k], c.at_px[k]);
                most[k] = std::max(most[k], c.at_px[k]);
            }
    fit.coverage = {(most[0] - least[0]) / first.width, (most[1] - least[1]) / first.height};
    const std::size_t along = std::abs(fit.view.along[0]) >= std::abs(fit.view.along[1]) ? 0 : 1;
    if (fit.coverage[along] < least_coverage)
        throw InputError{fmt::format(
            "calibrate camera: the corners cover {:.0f} % of the picture along the shaker's axis (from "
            "{:.0f} to "
            "{:.0f} px); at least {:.0f} % are needed for the lens: lay the board also near the ends",
            100 * fit.coverage[along], least[along], most[along], 100 * least_coverage)};
}

// `along` for a direction in the plane at `angle` from a towards b.
std::array<double, 2> along_at(const View& view, double angle) {
    constexpr double step_mm = 1e-3;
    const optics::Point foot = optics::image_of(view, 0, {0, 0});
    const optics::Point there =
        optics::image_of(view, 0, {step_mm * std::cos(angle), step_mm * std::sin(angle)});
    const double x = there[0] - foot[0], y = there[1] - foot[1], length = std::hypot(x, y);
    return {x / length, y / length};
}

// Direction in the plane of the line through the board's origins.
Estimate slid_direction(const PlaneModel& model, const VectorXd& x, std::size_t pictures) {
    constexpr double least_mm = 5;
    Eigen::Vector2d mean = Eigen::Vector2d::Zero();
    std::vector<Eigen::Vector2d> at;
    for (std::size_t k = 0; k < pictures; ++k) {
        const auto pose = model.pose_of(x, k);
        at.emplace_back(pose.origin_mm[0], pose.origin_mm[1]);
        mean += at.back() / static_cast<double>(pictures);
    }
    Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
    for (const auto& p : at) scatter += (p - mean) * (p - mean).transpose();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver{scatter};
    const double length = std::sqrt(solver.eigenvalues()[1]);
    if (pictures < 2 || length < least_mm)
        throw InputError{
            fmt::format("calibrate camera: --axis slid: the board was moved by {:.1f} mm (rms) in {} "
                        "pictures; at least {:.0f} mm are needed: push the base with the board on it",
                        length, pictures, least_mm)};
    const Eigen::Vector2d line = solver.eigenvectors().col(1) * (solver.eigenvectors()(0, 1) < 0 ? -1 : 1);
    const double off =
        pictures > 2 ? std::sqrt(std::max(0.0, solver.eigenvalues()[0]) / static_cast<double>(pictures - 2))
                     : std::numeric_limits<double>::quiet_NaN();
    return {std::atan2(line[1], line[0]), off / length};
}

void set_axis(PlaneFit& fit, const PlaneModel& model, const VectorXd& x, const MatrixXd& covariance,
              const BoardKnowledge& known, std::size_t pictures) {
    const double board = model.pose_of(x, 0).turn_rad;
    Estimate direction{0, std::sqrt(covariance(model.first_of_pose(0) + 2, model.first_of_pose(0) + 2))};
    if (known.axis == AxisFrom::board) direction.value = board;
    if (known.axis == AxisFrom::slid) direction = slid_direction(model, x, pictures);
    fit.axis_deg = {std::remainder(direction.value - board, 2 * std::numbers::pi) / degree,
                    direction.sigma / degree};
    if (known.axis != AxisFrom::settings) fit.view.along = along_at(fit.view, direction.value);
}

void set_camera(PlaneFit& fit, const PlaneModel& model, const VectorXd& x, const MatrixXd& covariance) {
    const auto entry = [&](int k) { return Estimate{x[k], std::sqrt(covariance(k, k))}; };
    fit.view = model.view_of(x);
    fit.tilt_x_deg = entry(2);
    fit.tilt_y_deg = entry(3);
    fit.centre_x_px = entry(4);
    fit.centre_y_px = entry(5);
    // From the picture's width as the unit of the radii to the focal length.
    const double focal =
        model.telecentric() ? fit.view.lens.focal_px : fit.view.distance_mm / fit.view.mm_per_px;
    const double unit = focal / fit.view.lens.focal_px, second = unit * unit;
    fit.view.lens.focal_px = focal;
    fit.view.lens.k1 *= second;
    fit.view.lens.k2 *= second * second;
    fit.k1 = {fit.view.lens.k1, second * entry(6).sigma};
    fit.k2 = {fit.view.lens.k2, second * second * entry(7).sigma};
    if (!model.telecentric()) fit.distance_mm = {fit.view.distance_mm, fit.view.distance_mm * entry(1).sigma};
}

// The scale must be known, and every point of the picture have a place.
void require_use(const PlaneFit& fit, int width, int height) {
    if (!(fit.view.scale_error <= worst_scale_error))
        throw InputError{fmt::format(
            "calibrate camera: the scale has an error of {:.2g} % in the {} plane; at most "
            "0.5 % is of use: {}",
            100 * fit.view.scale_error, fit.base_error >= fit.walker_error ? "base's" : "walker's",
            fit.base_error >= fit.walker_error ? "add pictures, and lay the board near the ends too"
                                               : "add pictures of the board at the walker's height")};
    for (const double px : {0.0, width - 1.0})
        for (const double py : {0.0, height - 1.0})
            if (!std::isfinite(metres_along(fit.view, 0, px, py)))
                throw InputError{fmt::format(
                    "calibrate camera: the fitted lens maps no ray to ({:.0f}, {:.0f}) px: lay the board "
                    "also near that corner",
                    px, py)};
}

void add_findings(PlaneFit& fit, const BoardKnowledge& known) {
    if (!fit.distance_found && known.settings.distance_mm > 0)
        fit.findings.push_back(
            fmt::format("the distance is that of the settings ({:.4g} +- {:.2g} mm): pictures at one height "
                        "do not determine "
                        "it; add pictures of the board raised by a known height (10 mm or more)",
                        fit.distance_mm.value, fit.distance_mm.sigma));
    if (fit.rejected > 0)
        fit.findings.push_back(
            fmt::format("{} corners lie more than 6 standard deviations off and are left out", fit.rejected));
    constexpr double good_rms_px = 0.1;
    if (fit.rms_px > good_rms_px)
        fit.findings.push_back(
            fmt::format("the corners lie {:.2f} px (rms) off; 0.05 px are usual: is the board flat, and its "
                        "length right in "
                        "both directions?",
                        fit.rms_px));
}

}  // namespace

double mean_scale(const View& view, double offset_mm, int width, int height) {
    constexpr double part = 0.4;
    const double ax = view.along[0], ay = view.along[1];
    const double half =
        part * std::min(width / std::max(std::abs(ax), 1e-9), height / std::max(std::abs(ay), 1e-9));
    const double x = 0.5 * (width - 1), y = 0.5 * (height - 1);
    return (metres_along(view, offset_mm, x + half * ax, y + half * ay) -
            metres_along(view, offset_mm, x - half * ax, y - half * ay)) /
           (2 * half);
}

PlaneFit fit_plane(std::span<const PlacedBoard> pictures, const optics::Board& board,
                   const BoardKnowledge& known) {
    require_corners(pictures);
    PlaneModel model{pictures, board, known};
    VectorXd x = model.start();
    constexpr double first_noise_px = 0.02, least_noise_px = 1e-4;
    PlaneFit fit;
    fit.view = known.settings;
    require_coverage(fit, pictures);
    double noise = first_noise_px;
    for (int pass = 0; pass < 3; ++pass) {
        minimise(model, x, noise);
        if (pass == 0) fit.rejected = reject(model, x);
        if (pass < 2) model.correct_bends(x);
        noise = std::max(least_noise_px, noise_of(model.normal(x, noise), x.size()));
    }
    const PlaneModel::Normal normal = model.normal(x, noise);
    const VectorXd root = normal.matrix.diagonal().cwiseSqrt().cwiseInverse();
    const MatrixXd balanced = root.asDiagonal() * normal.matrix * root.asDiagonal();
    const MatrixXd covariance =
        root.asDiagonal() * balanced.ldlt().solve(MatrixXd::Identity(x.size(), x.size())) * root.asDiagonal();
    set_camera(fit, model, x, covariance);
    fit.noise_px = noise;
    fit.rms_px = std::sqrt(normal.squares_px / normal.count);
    fit.corners = normal.count / 2;
    for (const auto& o : model.observations) {
        const Eigen::Vector2d off = model.residual(x, o);
        fit.residuals.push_back({o.picture, o.corner.at_px, {off[0], off[1]}, o.used});
    }
    set_axis(fit, model, x, covariance, known, pictures.size());
    const int width = pictures.front().seen.width, height = pictures.front().seen.height;
    const auto error_at = [&](double offset_mm) {
        return error_of(x, covariance, [&](const VectorXd& at) {
            View view = model.view_of(at);
            view.along = fit.view.along;
            return std::log(mean_scale(view, offset_mm, width, height));
        });
    };
    fit.base_error = error_at(0);
    fit.walker_error = error_at(known.walker_offset_mm);
    fit.view.scale_error = std::max(fit.base_error, fit.walker_error);
    constexpr double better = 0.5;
    fit.distance_found =
        !model.telecentric() && fit.distance_mm.sigma < better * known.distance_error * fit.distance_mm.value;
    require_use(fit, width, height);
    add_findings(fit, known);
    return fit;
}

}  // namespace shaker::calibration

#include "drivers/optics/plane.hpp"

#include <cmath>
#include <limits>
#include <numbers>

namespace shaker::optics {

namespace {

using Axis = std::array<double, 3>;

double dot(const Axis& a, const Axis& b) noexcept { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

struct PlaneAxes {
    Axis along{}, across{}, away{};  // away: the normal that points away from the camera
    double slope_x, slope_y, root;

    explicit PlaneAxes(const View& view) noexcept
        : slope_x{std::tan(view.tilt_deg[0] * std::numbers::pi / 180)},
          slope_y{std::tan(view.tilt_deg[1] * std::numbers::pi / 180)},
          root{std::sqrt(1 + slope_x * slope_x + slope_y * slope_y)} {
        away = {-slope_x / root, -slope_y / root, 1 / root};
        const double rise = slope_x * view.along[0] + slope_y * view.along[1];
        const double length = std::sqrt(1 + rise * rise);
        along = {view.along[0] / length, view.along[1] / length, rise / length};
        for (std::size_t i = 0; i < 3; ++i) {
            const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
            across[i] = away[j] * along[k] - away[k] * along[j];
        }
    }
};

}  // namespace

Point image_of(const View& view, double offset_mm, const Point& place_mm) noexcept {
    if (view.lens.focal_px <= 0) {
        const double scale = mm_per_px_at(view, offset_mm);
        return {(view.along[0] * place_mm[0] - view.along[1] * place_mm[1]) / scale,
                (view.along[1] * place_mm[0] + view.along[0] * place_mm[1]) / scale};
    }
    const PlaneAxes axes{view};
    Axis at{};
    for (std::size_t i = 0; i < 3; ++i)
        at[i] = place_mm[0] * axes.along[i] + place_mm[1] * axes.across[i] - offset_mm * axes.away[i];
    const double shrink = view.distance_mm > 0 ? 1 + at[2] / view.distance_mm : 1;
    const double unit = view.mm_per_px * view.lens.focal_px * shrink;
    const Point seen = view.lens.distorted(at[0] / unit, at[1] / unit);
    return {view.lens.centre_px[0] + view.lens.focal_px * seen[0],
            view.lens.centre_px[1] + view.lens.focal_px * seen[1]};
}

Point place_at(const View& view, double offset_mm, const Point& sensor_px) noexcept {
    if (view.lens.focal_px <= 0) {
        const double scale = mm_per_px_at(view, offset_mm);
        return {scale * (view.along[0] * sensor_px[0] + view.along[1] * sensor_px[1]),
                scale * (view.along[0] * sensor_px[1] - view.along[1] * sensor_px[0])};
    }
    const PlaneAxes axes{view};
    const auto [u, v] = undistorted(view.lens, sensor_px);
    double x = view.mm_per_px * view.lens.focal_px * u, y = view.mm_per_px * view.lens.focal_px * v;
    double nearer = offset_mm * axes.root;
    if (view.distance_mm > 0) {
        const double stretch =
            (view.distance_mm - nearer) / (view.distance_mm - axes.slope_x * x - axes.slope_y * y);
        x *= stretch;
        y *= stretch;
    }
    const Axis at{x, y, axes.slope_x * x + axes.slope_y * y - nearer};
    return {dot(at, axes.along), dot(at, axes.across)};
}

Point undistorted(const Lens& lens, const Point& sensor_px) noexcept {
    constexpr double tolerance = 1e-13, most = 10;
    constexpr int steps = 30;
    const double u = (sensor_px[0] - lens.centre_px[0]) / lens.focal_px;
    const double v = (sensor_px[1] - lens.centre_px[1]) / lens.focal_px;
    double x = u, y = v;
    for (int i = 0; i < steps; ++i) {  // Newton
        const auto [at_x, at_y] = lens.distorted(x, y);
        const double r2 = x * x + y * y, radial = 1 + r2 * (lens.k1 + r2 * lens.k2);
        const double slope = 2 * (lens.k1 + 2 * r2 * lens.k2);
        const double xx = radial + x * x * slope + 2 * lens.p1 * y + 6 * lens.p2 * x;
        const double xy = x * y * slope + 2 * lens.p1 * x + 2 * lens.p2 * y;
        const double yy = radial + y * y * slope + 6 * lens.p1 * y + 2 * lens.p2 * x;
        const double area = xx * yy - xy * xy;
        if (!(area > 0)) break;  // the distortion folds the picture
        const double dx = (yy * (u - at_x) - xy * (v - at_y)) / area;
        const double dy = (xx * (v - at_y) - xy * (u - at_x)) / area;
        x += dx;
        y += dy;
        if (std::abs(dx) + std::abs(dy) < tolerance) return {x, y};
        if (!(std::abs(x) + std::abs(y) < most)) break;
    }
    constexpr double none = std::numeric_limits<double>::quiet_NaN();
    return {none, none};
}

}  // namespace shaker::optics

#include "calibration/camera/camera_scale.hpp"

#include <cmath>
#include <limits>
#include <numbers>

namespace shaker::calibration {

namespace {

// Place on the shaker's axis, mm, of a point of the sensor.
double corrected_mm(const View& view, double offset_mm, double x_px, double y_px) noexcept {
    constexpr double degree = std::numbers::pi / 180;
    const auto [u, v] = undistorted(view.lens, x_px, y_px);
    const double slope_x = std::tan(degree * view.tilt_deg[0]), slope_y = std::tan(degree * view.tilt_deg[1]);
    const double along_z = slope_x * view.along[0] + slope_y * view.along[1];
    double x = view.mm_per_px * view.lens.focal_px * u, y = view.mm_per_px * view.lens.focal_px * v;
    if (view.distance_mm > 0) {
        const double away =
            view.distance_mm - offset_mm * std::sqrt(1 + slope_x * slope_x + slope_y * slope_y);
        const double stretch = away / (view.distance_mm - slope_x * x - slope_y * y);
        x *= stretch;
        y *= stretch;
    }
    const double z = slope_x * x + slope_y * y;
    return (view.along[0] * x + view.along[1] * y + along_z * z) / std::sqrt(1 + along_z * along_z);
}

}  // namespace

std::array<double, 2> undistorted(const Lens& lens, double x_px, double y_px) noexcept {
    constexpr double tolerance = 1e-13, most = 10;
    constexpr int steps = 30;
    const double u = (x_px - lens.centre_px[0]) / lens.focal_px,
                 v = (y_px - lens.centre_px[1]) / lens.focal_px;
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

double metres_along(const View& view, double offset_mm, double x_px, double y_px) noexcept {
    if (view.lens.focal_px > 0)
        return 1e-3 * corrected_mm(view, offset_mm, view.origin_px[0] + x_px, view.origin_px[1] + y_px);
    return 1e-3 * mm_per_px_at(view, offset_mm) * (view.along[0] * x_px + view.along[1] * y_px);
}

double mm_per_px_at(const View& view, double offset_mm, double x_px, double y_px) noexcept {
    if (view.lens.focal_px <= 0) return mm_per_px_at(view, offset_mm);
    constexpr double half = 0.5;  // px
    const double dx = half * view.along[0], dy = half * view.along[1];
    return 1e3 * (metres_along(view, offset_mm, x_px + dx, y_px + dy) -
                  metres_along(view, offset_mm, x_px - dx, y_px - dy));
}

}  // namespace shaker::calibration

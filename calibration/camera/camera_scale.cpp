#include "calibration/camera/camera_scale.hpp"

namespace shaker::calibration {

double metres_along(const View& view, double offset_mm, double x_px, double y_px) noexcept {
    if (view.lens.focal_px > 0)
        return 1e-3 *
               optics::place_at(view, offset_mm, {view.origin_px[0] + x_px, view.origin_px[1] + y_px})[0];
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

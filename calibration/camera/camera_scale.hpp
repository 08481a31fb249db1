#pragma once
// Pixels to metres for one target of one view.
#include "drivers/view.hpp"

namespace shaker::calibration {

/// Scale of an object plane at `offset_mm` from the reference plane (positive towards the camera): s = s_ref
/// (1 - offset / distance). distance 0: telecentric, no parallax.
inline double mm_per_px_at(const View& view, double offset_mm) noexcept {
    return view.distance_mm > 0 ? view.mm_per_px * (1 - offset_mm / view.distance_mm) : view.mm_per_px;
}

/// Position along the shaker's axis in metres for an image point in px: x = s (along . (x_px, y_px)). Its
/// zero is the image's origin, so only differences are meaningful.
inline double metres_along(const View& view, double offset_mm, double x_px, double y_px) noexcept {
    return 1e-3 * mm_per_px_at(view, offset_mm) * (view.along[0] * x_px + view.along[1] * y_px);
}

}  // namespace shaker::calibration

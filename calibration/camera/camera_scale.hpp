#pragma once
// Pixels to metres for one target of one view.
#include <array>

#include "drivers/view.hpp"

namespace shaker::calibration {

/// Scale of an object plane at `offset_mm` from the reference plane (positive towards the camera): s = s_ref
/// (1 - offset / distance). distance 0: telecentric, no parallax. With a lens: at its centre.
inline double mm_per_px_at(const View& view, double offset_mm) noexcept {
    return view.distance_mm > 0 ? view.mm_per_px * (1 - offset_mm / view.distance_mm) : view.mm_per_px;
}

/// Position along the shaker's axis in metres for an image point in px: x = s (along . (x_px, y_px)). Its
/// zero is constant in one plane and arbitrary, so only differences are meaningful.
///
/// With a lens the point is corrected, not the image: the distortion is removed, the ray is intersected with
/// the target's plane Z = Z_0 + X tan(tilt_x) + Y tan(tilt_y) (camera axes, Z along the optical axis, Z_0 =
/// distance_mm, moved by offset_mm along its normal), and the place projected on the shaker's axis, which
/// lies in the plane and appears along `along` at the lens's centre. NaN where the lens maps no ray to the
/// point.
double metres_along(const View& view, double offset_mm, double x_px, double y_px) noexcept;

/// Millimetres along the shaker's axis per px of motion along `along` at an image point: mm_per_px_at(view,
/// offset_mm) without a lens.
double mm_per_px_at(const View& view, double offset_mm, double x_px, double y_px) noexcept;

/// The point in units of focal_px from the centre that the lens maps to a point of the sensor, px. NaN where
/// there is none.
std::array<double, 2> undistorted(const Lens& lens, double x_px, double y_px) noexcept;

}  // namespace shaker::calibration

#pragma once
// Places in a plane and where a camera's lens puts them on the sensor.
#include <array>

#include "drivers/view.hpp"

namespace shaker::optics {

/// Millimetres or pixels.
using Point = std::array<double, 2>;

/// Axes, with Z along the optical axis away from the camera: the reference plane is Z = Z_0 + X tan(tilt_x) +
/// Y tan(tilt_y) with Z_0 = distance_mm; a plane at offset_mm is shifted by it along the normal, towards the
/// camera. Places in a plane are (a, b) in mm, from the foot of the optical axis on the reference plane: a
/// lies along the shaker's axis, which appears along `along` at the lens's centre; b is square to it, turned
/// as image y against x. A place appears at centre + focal_px distorted(x, y) with
/// x = (distance_mm / mm_per_px / focal_px) X / Z, or X / (mm_per_px focal_px) for a telecentric lens.
/// Without a lens a = s (along . (x_px, y_px)), from the image's origin.

/// Point of the sensor, px.
Point image_of(const View& view, double offset_mm, const Point& place_mm) noexcept;

/// The place that appears at a point of the sensor. NaN where the lens maps none to it.
Point place_at(const View& view, double offset_mm, const Point& sensor_px) noexcept;

/// The point in units of focal_px from the centre that the lens maps to a point of the sensor; NaN if none.
Point undistorted(const Lens& lens, const Point& sensor_px) noexcept;

/// Scale at the lens's centre of a plane at `offset_mm`: s = s_ref (1 - offset / distance); distance 0:
/// telecentric, no parallax.
inline double mm_per_px_at(const View& view, double offset_mm) noexcept {
    return view.distance_mm > 0 ? view.mm_per_px * (1 - offset_mm / view.distance_mm) : view.mm_per_px;
}

}  // namespace shaker::optics

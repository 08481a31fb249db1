#pragma once
// Pixels to metres for one target of one view.
#include "drivers/optics/plane.hpp"

namespace shaker::calibration {

using optics::mm_per_px_at;

/// Position along the shaker's axis in metres for an image point in px: x = s (along . (x_px, y_px)). Its
/// zero is constant in one plane and arbitrary, so only differences are meaningful.
///
/// With a lens the point is corrected, not the image: its place in the target's plane is optics::place_at().
/// NaN where the lens maps none to it.
double metres_along(const View& view, double offset_mm, double x_px, double y_px) noexcept;

/// Millimetres along the shaker's axis per px of motion along `along` at an image point: mm_per_px_at(view,
/// offset_mm) without a lens.
double mm_per_px_at(const View& view, double offset_mm, double x_px, double y_px) noexcept;

}  // namespace shaker::calibration

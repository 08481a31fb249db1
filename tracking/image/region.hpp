#pragma once
// Checks of the region in which a target starts, and error messages for it.
#include <optional>
#include <string>

#include "drivers/errors.hpp"
#include "drivers/view.hpp"
#include "tracking/image/pixels.hpp"

namespace shaker::tracking {

/// One target of a view with lengths in px: the input of every locator.
struct Subject {
    std::string label;  // "camera top, target walker, region [x, y, width, height]"
    Target target;
    std::array<double, 2> along{1, 0};
    double mm_per_px = 0;  // in the target's own plane
};

Subject subject_of(const View& view, const Target& target);

/// A length in the settings that the first picture contradicts.
struct Correction {
    std::string key;  // of the settings: "diameter_mm"
    double told_mm = 0, measured_mm = 0;
};

/// Empty when the settings have no length, or when it is right to 1 % or a quarter of a pixel. told_px,
/// measured_px: the same length.
std::optional<Correction> correction_of(std::string key, double told_mm, double told_px, double measured_px);

/// The target's region, clipped to the image. Throws InputError if it is smaller than 4 px or less than half
/// of it is inside the image.
Box region_in(const Subject& subject, const ImageView& image);

/// Grey levels of a region: 1st, 50th and 99th percentile.
struct Levels {
    double low = 0, middle = 0, high = 0;
};
/// Throws InputError when the region has no contrast.
Levels levels_in(const Subject& subject, const ImageView& image, const Box& box);

/// The image axis nearest to `along`, for methods that measure in one direction. Throws InputError if the
/// angle between them exceeds 20 degrees.
Axis axis_of(const Subject& subject);

/// Length in px along the image axis nearest to `along`; an oblique edge is wider by 1/cos of the angle.
double crossing_px(const Subject& subject, double length_mm);

}  // namespace shaker::tracking

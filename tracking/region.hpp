#pragma once
// The region a target starts in, checked, and the words for what is wrong with it.
#include <string>

#include "drivers/errors.hpp"
#include "drivers/view.hpp"
#include "tracking/pixels.hpp"

namespace shaker {

/// One target of a view with its lengths in px: what every locator is made from.
struct Subject {
    std::string label;  // "camera top, target walker, region [x, y, width, height]"
    Target target;
    std::array<double, 2> along{1, 0};
    double mm_per_px = 0;  // in the target's own plane
};

Subject subject_of(const View& view, const Target& target);

/// The target's region as a box, clipped to the image. Throws InputError when it is under 4 px or less than
/// half of it is inside.
Box region_in(const Subject& subject, const ImageView& image);

/// Levels of a region: 1st, 50th and 99th percentile.
struct Levels {
    double low = 0, middle = 0, high = 0;
};
/// Throws InputError when the region has no contrast.
Levels levels_in(const Subject& subject, const ImageView& image, const Box& box);

/// The image axis nearest to `along`, for methods that measure one direction. Throws InputError beyond 20
/// degrees.
Axis axis_of(const Subject& subject);

/// Length in px along the image axis nearest to `along`: an oblique edge crosses a row in 1/cos of it.
double crossing_px(const Subject& subject, double length_mm);

}  // namespace shaker

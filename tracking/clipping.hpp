#pragma once
// Pixels at the end of a sensor's range.
#include "tracking/image/pixels.hpp"

namespace shaker::tracking {

/// Share of a box's pixels that have the largest code of their depth (2^k - 1, k >= 8, or that shifted to the
/// left), from at most 32 of its rows. 0 for a box outside the image.
double clipped_share(const ImageView& image, const Box& box);

}  // namespace shaker::tracking

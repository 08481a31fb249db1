#pragma once
// Means of a band of pixels across one image axis: a picture as a line.
#include <span>

#include "tracking/pixels.hpp"

namespace shaker {

/// Length of the image along `axis`.
constexpr int length_along(const ImageView& image, Axis axis) noexcept {
    return axis == Axis::x ? image.width : image.height;
}
constexpr int length_across(const ImageView& image, Axis axis) noexcept {
    return axis == Axis::x ? image.height : image.width;
}

/// out[i] = mean over across0 <= j < across1 of the pixel at `first + i` along `axis`. All of it must be
/// inside the image.
void mean_profile(const ImageView& image, Axis axis, int first, int across0, int across1,
                  std::span<double> out);

}  // namespace shaker

#pragma once
// One-dimensional profile of an image: means over a band across an axis.
#include <span>

#include "tracking/image/pixels.hpp"

namespace shaker::tracking {

/// Length of the image along `axis`.
constexpr int length_along(const ImageView& image, Axis axis) noexcept {
    return axis == Axis::x ? image.width : image.height;
}
constexpr int length_across(const ImageView& image, Axis axis) noexcept {
    return axis == Axis::x ? image.height : image.width;
}

/// out[i] = mean over across0 <= j < across1 of the pixel at `first + i` along `axis`. The whole band must be
/// inside the image.
void mean_profile(const ImageView& image, Axis axis, int first, int across0, int across1,
                  std::span<double> out);
void mean_profile(const ImageView& image, Axis axis, int first, int across0, int across1,
                  std::span<float> out);

}  // namespace shaker::tracking

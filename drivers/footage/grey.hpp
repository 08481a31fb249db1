#pragma once
// Grey pictures of OpenCV's matrices.
#include <cstddef>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "drivers/footage/media.hpp"

namespace shaker::footage {

/// Grey that was stored as colour is recovered exactly; real colour is weighted, which rounds.
cv::Mat grey_of(const cv::Mat& image);
PictureFormat format_of(const cv::Mat& image);
/// Without padding, top row first.
void copy_pixels(const cv::Mat& grey, std::vector<std::byte>& pixels);
/// InputError, which names `what`, unless `here` is the format of the first picture.
void require_format(const std::string& what, const PictureFormat& here, const PictureFormat& first);

}  // namespace shaker::footage

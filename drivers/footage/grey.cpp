#include "drivers/footage/grey.hpp"

#include <cstring>
#include <opencv2/imgproc.hpp>

#include "drivers/errors.hpp"

namespace shaker::footage {
namespace {

bool same_channels(const cv::Mat& image) {
    const auto channels = static_cast<std::size_t>(image.channels());
    const std::size_t bytes = image.elemSize1();
    for (int y = 0; y < image.rows; ++y) {
        const auto* pixel = image.ptr<std::byte>(y);
        for (int x = 0; x < image.cols; ++x, pixel += channels * bytes)
            if (std::memcmp(pixel, pixel + bytes, bytes) != 0 ||
                std::memcmp(pixel, pixel + 2 * bytes, bytes) != 0)
                return false;
    }
    return true;
}

std::string described(const PictureFormat& f) {
    return std::to_string(f.width) + " x " + std::to_string(f.height) + " pixels of " +
           std::to_string(8 * f.bytes_per_pixel) + " bits";
}

}  // namespace

cv::Mat grey_of(const cv::Mat& image) {
    cv::Mat grey;
    if (image.channels() == 1) return image;
    if (image.channels() == 2 || same_channels(image))
        cv::extractChannel(image, grey, 0);
    else
        cv::cvtColor(image, grey, image.channels() == 4 ? cv::COLOR_BGRA2GRAY : cv::COLOR_BGR2GRAY);
    return grey;
}

PictureFormat format_of(const cv::Mat& image) {
    return {image.cols, image.rows, static_cast<int>(image.elemSize1())};
}

void copy_pixels(const cv::Mat& grey, std::vector<std::byte>& pixels) {
    const std::size_t row = static_cast<std::size_t>(grey.cols) * grey.elemSize();
    pixels.resize(row * static_cast<std::size_t>(grey.rows));
    for (int y = 0; y < grey.rows; ++y)
        std::memcpy(&pixels[static_cast<std::size_t>(y) * row], grey.ptr<std::byte>(y), row);
}

void require_format(const std::string& what, const PictureFormat& here, const PictureFormat& first) {
    if (here != first)
        throw InputError{what + " has " + described(here) + ", the first one has " + described(first)};
}

}  // namespace shaker::footage

#include "calibration/camera/grey_picture.hpp"

#include <algorithm>
#include <cstring>
#include <opencv2/core.hpp>

#include "drivers/codecs/codecs.hpp"

namespace shaker::calibration {

GreyPicture grey_picture(const ImageView& image) {
    GreyPicture picture{.width = image.width, .height = image.height};
    picture.grey.reserve(static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height));
    float most = 1;
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x) {
            const std::byte* at = image.row(y) + std::ptrdiff_t{x} * image.bytes_per_pixel;
            float grey = std::to_integer<std::uint8_t>(*at);
            if (image.bytes_per_pixel == 2) {
                std::uint16_t wide{};
                std::memcpy(&wide, at, sizeof wide);
                grey = wide;
            }
            most = std::max(most, grey);
            picture.grey.push_back(grey);
        }
    if (image.bytes_per_pixel == 2)
        for (float& g : picture.grey) g *= 255 / most;
    return picture;
}

GreyPicture read_picture(const std::filesystem::path& file) {
    constexpr std::array<float, 3> weights{0.114F, 0.587F, 0.299F};  // blue, green, red
    const cv::Mat image = codecs::read_image(file.string());
    const int channels = image.channels();
    const bool wide = image.depth() == CV_16U;
    GreyPicture picture{.width = image.cols, .height = image.rows};
    float most = 1;
    for (int y = 0; y < image.rows; ++y)
        for (int x = 0; x < image.cols; ++x) {
            float grey = 0;
            for (int k = 0; k < std::min(channels, 3); ++k) {
                const int at = channels * x + k;
                const float value = wide ? image.ptr<std::uint16_t>(y)[at] : image.ptr<std::uint8_t>(y)[at];
                grey += channels < 3 ? (k == 0 ? value : 0) : weights[static_cast<std::size_t>(k)] * value;
            }
            most = std::max(most, grey);
            picture.grey.push_back(grey);
        }
    if (wide)
        for (float& g : picture.grey) g *= 255 / most;
    return picture;
}

}  // namespace shaker::calibration

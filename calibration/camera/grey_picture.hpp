#pragma once
// A grey picture whose pixels are read as numbers.
#include <filesystem>
#include <vector>

#include "drivers/data.hpp"

namespace shaker::calibration {

/// Grey levels by rows; pixel centres are at whole numbers.
struct GreyPicture {
    int width = 0, height = 0;
    std::vector<float> grey{};
    [[nodiscard]] double at(int x, int y) const noexcept {
        return grey[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                    static_cast<std::size_t>(x)];
    }
};

/// 8 bits as they are; 16 bits scaled so that the lightest pixel is 255.
GreyPicture grey_picture(const ImageView& image);

/// An image file; colours by their luminance. InputError for one that cannot be read.
GreyPicture read_picture(const std::filesystem::path& file);

}  // namespace shaker::calibration

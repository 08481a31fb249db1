#pragma once
// A grey picture whose pixels are read as numbers, and the corners of a board in it.
#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "drivers/data.hpp"
#include "drivers/optics/board.hpp"

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

struct SeenCorner {
    int number = 0;  // Board::corner()
    std::array<double, 2> at_px{};
    double reach_px = 0;  // FittedCorner::reach_px
};

struct SeenBoard {
    std::string name;  // of the picture: file or number
    int width = 0, height = 0;
    int markers = 0;  // found
    double blur = 0;  // median sigma, px
    std::vector<SeenCorner> corners{};
};

/// Finds markers by OpenCV's aruco, and fits every corner between two squares whose markers say where it is
/// (fit_corner()). Parts of the board may be outside of the picture. Throws DeviceError without the module of
/// OpenCV.
SeenBoard find_board(const GreyPicture& picture, const optics::Board& board, std::string name);

}  // namespace shaker::calibration

#pragma once
// The corners of a board in a picture.
#include <string>
#include <vector>

#include "calibration/camera/grey_picture.hpp"
#include "drivers/optics/board.hpp"

namespace shaker::calibration {

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

#include "drivers/optics/board.hpp"

#include <gtest/gtest.h>

#include <opencv2/aruco/charuco.hpp>

namespace shaker::optics {
namespace {

// OpenCV 4.6 draws the same board where the number of rows is odd.
TEST(BoardTest, IsTheBoardThatOpenCvDraws) {
    constexpr int cell_px = 6;  // 10 px of margin, 60 px of marker
    for (const auto& [columns, rows] : {std::array{17, 11}, std::array{8, 5}}) {
        const Board board{.columns = columns, .rows = rows, .square_mm = 8, .marker_mm = 6};
        const auto drawn = cv::aruco::CharucoBoard::create(
            columns, rows, 8, 6, cv::aruco::getPredefinedDictionary(cv::aruco::DICT_4X4_250));
        cv::Mat picture;
        const int square_px = cells_of_square * cell_px;
        drawn->draw({columns * square_px, rows * square_px}, picture);
        for (int y = 0; y < rows * cells_of_square; ++y)
            for (int x = 0; x < columns * cells_of_square; ++x)
                ASSERT_EQ(dark_cell(board, x, y), picture.at<std::uint8_t>(y * cell_px + cell_px / 2,
                                                                           x * cell_px + cell_px / 2) < 128)
                    << columns << " columns, cell " << x << ", " << y;
    }
}

}  // namespace
}  // namespace shaker::optics

#pragma once
// ChArUco board: a chess board with a marker in each light square, and its pictures as a camera sees them,
// with exact sub-pixel edges.
#include <cstdint>
#include <vector>

#include "drivers/optics/plane.hpp"

namespace shaker::optics {

/// Number of markers of OpenCV's dictionary DICT_4X4_250.
inline constexpr int markers = 250;

/// Squares from the top left, which is dark; light squares hold the markers 0, 1, ... by rows, as OpenCV 4.7
/// and later number them (4.6: where `rows` is odd). Origin of places: the top left corner of the board, x to
/// the right, y down, mm.
struct Board {
    int columns = 17, rows = 11;
    double square_mm = 10;
    double marker_mm = 7;
    bool operator==(const Board&) const = default;

    /// Inner corners, by rows.
    [[nodiscard]] int corners() const noexcept { return (columns - 1) * (rows - 1); }
    [[nodiscard]] Point corner(int number) const noexcept {
        return {square_mm * (number % (columns - 1) + 1), square_mm * (number / (columns - 1) + 1)};
    }
    /// The marker of a light square.
    [[nodiscard]] int marker_of(int column, int row) const noexcept { return (row * columns + column) / 2; }
    [[nodiscard]] bool fits() const noexcept { return columns * rows / 2 <= markers; }
};

/// Cells of one square, along either side: a margin, six cells of the marker, a margin.
inline constexpr int cells_of_square = 8;
/// First edge of a cell in its square, mm.
double cell_edge(const Board& board, int cell) noexcept;
/// Whether a cell is dark; cells are counted over the whole board.
bool dark_cell(const Board& board, int x, int y) noexcept;

/// Where a board lies in a plane: the place of its origin, and the angle from a to its x, towards b.
struct BoardPose {
    Point origin_mm{};
    double turn_rad = 0;
    double offset_mm = 0;  // of its printed face from the reference plane, towards the camera
    [[nodiscard]] Point place_of(const Point& on_board_mm) const noexcept;
    [[nodiscard]] Point on_board(const Point& place_mm) const noexcept;
};

struct BoardLight {
    double dark = 30, light = 200, ground = 60;  // grey levels of 255
    double psf_px = 0.7;                         // Gaussian sigma of the lens
    double noise_dn = 2;                         // rms
    double gradient = 0;                         // relative change of brightness from left to right, +-
};

/// Picture of 8 bits, by rows. Each pixel is the mean over its area and the lens's blur, exact to second
/// order in the change of scale over a pixel.
std::vector<std::uint8_t> board_picture(const Board& board, const View& view, const BoardPose& pose,
                                        int width, int height, const BoardLight& light, std::uint64_t seed);

}  // namespace shaker::optics

#pragma once
// ChArUco board: a chess board with a marker in each light square.
#include <array>
#include <cstdint>

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

}  // namespace shaker::optics

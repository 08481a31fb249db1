#include "calibration/camera/board_pdf.hpp"

#include <spdlog/fmt/fmt.h>

#include "calibration/camera/pdf_page.hpp"

namespace shaker::calibration {

namespace {

double edge(const optics::Board& board, int cell) {
    return cell / optics::cells_of_square * board.square_mm +
           optics::cell_edge(board, cell % optics::cells_of_square);
}

// Dark rectangles; the board's y grows downwards, the page's upwards.
std::string drawing(const optics::Board& board, double left_mm, double top_mm) {
    const int wide = optics::cells_of_square * board.columns, high = optics::cells_of_square * board.rows;
    std::string text;
    for (int y = 0; y < high; ++y)
        for (int x = 0; x < wide;) {
            if (!optics::dark_cell(board, x, y)) {
                ++x;
                continue;
            }
            const int from = x;
            while (x < wide && optics::dark_cell(board, x, y)) ++x;
            const double height = edge(board, y + 1) - edge(board, y);
            text += fmt::format("{:.5f} {:.5f} {:.5f} {:.5f} re\n", left_mm + edge(board, from),
                                top_mm - edge(board, y) - height, edge(board, x) - edge(board, from), height);
        }
    return text + "f\n";
}

}  // namespace

std::string board_pdf(const optics::Board& board) {
    constexpr double text_mm = 3;
    const double margin = 2 * board.square_mm;
    const double width = board.columns * board.square_mm + 2 * margin;
    const double height = board.rows * board.square_mm + 2 * margin;
    std::string page = drawing(board, margin, height - margin);
    page += fmt::format(
        "BT /F1 {:.3f} Tf {:.4f} {:.4f} Td (shakerd {} x {} squares of {} mm, markers of {} mm "
        "\\(DICT_4X4_250\\). "
        "Print at 100 %. Measure {} squares: {} mm) Tj ET\n",
        text_mm, margin, 0.5 * margin, board.columns, board.rows, board.square_mm, board.marker_mm,
        board.columns, board.columns * board.square_mm);
    return pdf_page(width, height, page);
}

}  // namespace shaker::calibration

#include "calibration/camera/printed_targets.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace shaker::calibration {

namespace {

/// A page of exact size with a drawing: PDF operators in mm from the page's lower left corner. /F1 is
/// Helvetica.
std::string pdf_page(double width_mm, double height_mm, const std::string& drawing) {
    constexpr double points_per_mm = 72 / 25.4;
    const std::string content =
        fmt::format("{:.6f} 0 0 {:.6f} 0 0 cm\n", points_per_mm, points_per_mm) + drawing;
    const std::vector<std::string> objects{
        "<< /Type /Catalog /Pages 2 0 R >>", "<< /Type /Pages /Kids [3 0 R] /Count 1 >>",
        fmt::format(
            "<< /Type /Page /Parent 2 0 R /MediaBox [0 0 {:.4f} {:.4f}] /Contents 4 0 R /Resources << "
            "/Font << /F1 5 0 R >> >> >>",
            width_mm * points_per_mm, height_mm * points_per_mm),
        fmt::format("<< /Length {} >>\nstream\n{}endstream", content.size(), content),
        "<< /Type /Font /Subtype /Type1 /BaseFont /Helvetica >>"};
    std::string pdf = "%PDF-1.4\n";
    std::string table = fmt::format("xref\n0 {}\n0000000000 65535 f \n", objects.size() + 1);
    for (std::size_t i = 0; i < objects.size(); ++i) {
        table += fmt::format("{:010} 00000 n \n", pdf.size());
        pdf += fmt::format("{} 0 obj\n{}\nendobj\n", i + 1, objects[i]);
    }
    return pdf + fmt::format("{}trailer\n<< /Size {} /Root 1 0 R >>\nstartxref\n{}\n%%EOF\n", table,
                             objects.size() + 1, pdf.size());
}

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

std::string strip_pdf(const optics::BarCode& code, double height_mm) {
    constexpr double margin = 10, text_mm = 3, line_mm = 0.3, tick_mm = 4;
    const double bottom = margin + 15;
    // In whole centimetres, as they are on a ruler.
    const double ruler = std::max(10.0, 10 * std::floor(code.length_mm / 10));
    const auto box = [](double x, double y, double width, double height) {
        return fmt::format("{:.5f} {:.5f} {:.5f} {:.5f} re\n", x, y, width, height);
    };
    std::string drawing;
    const std::vector<double> edges = optics::edges_of(code);
    for (std::size_t k = 0; k + 1 < edges.size(); k += 2)
        drawing += box(margin + edges[k], bottom, edges[k + 1] - edges[k], height_mm);
    // The ruler's length is that between the outer sides of its ticks.
    drawing += box(margin, margin + 8, ruler, line_mm) + box(margin, margin + 6, line_mm, tick_mm) +
               box(margin + ruler - line_mm, margin + 6, line_mm, tick_mm) + "f\n";
    const double letters = std::min(text_mm, (code.length_mm + margin) / 35);  // short strips: both lines fit
    const auto line = [&](double y, const std::string& text) {
        return fmt::format("BT /F1 {:.3f} Tf {:.4f} {:.4f} Td ({}) Tj ET\n", letters, margin, y, text);
    };
    drawing += line(margin + 1, fmt::format("Print at 100 %: the line is {} mm long.", ruler));
    drawing +=
        line(margin - 4, fmt::format("shakerd strip {} mm x {} mm, bars {} to {} mm, seed {}", code.length_mm,
                                     height_mm, code.least_mm, code.most_mm, code.seed));
    return pdf_page(code.length_mm + 2 * margin, bottom + height_mm + margin, drawing);
}

}  // namespace shaker::calibration

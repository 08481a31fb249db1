#include "calibration/camera/strip_pdf.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>

#include "calibration/camera/pdf_page.hpp"

namespace shaker::calibration {

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

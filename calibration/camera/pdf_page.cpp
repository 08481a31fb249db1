#include "calibration/camera/pdf_page.hpp"

#include <spdlog/fmt/fmt.h>

#include <vector>

namespace shaker::calibration {

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

}  // namespace shaker::calibration

#pragma once
// A PDF of one page.
#include <string>

namespace shaker::calibration {

/// A page of exact size with a drawing: PDF operators in mm from the page's lower left corner. /F1 is
/// Helvetica.
std::string pdf_page(double width_mm, double height_mm, const std::string& drawing);

}  // namespace shaker::calibration

#pragma once
// A strip of bars for the base, on paper.
#include <string>

#include "drivers/optics/bar_code.hpp"

namespace shaker::calibration {

/// A PDF of one page: the strip at its exact size with a frame of bright paper, under it a line of known
/// length to check the printer with, and the strip's parameters.
std::string strip_pdf(const optics::BarCode& code, double height_mm);

}  // namespace shaker::calibration

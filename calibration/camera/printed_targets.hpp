#pragma once
// A board, and a strip of bars for the base, on paper.
#include <string>

#include "drivers/optics/bar_code.hpp"
#include "drivers/optics/board.hpp"

namespace shaker::calibration {

/// A PDF of one page: the board at its exact size, a margin of two squares, and a line that states what was
/// printed and which length to measure.
std::string board_pdf(const optics::Board& board);

/// A PDF of one page: the strip at its exact size with a frame of bright paper, under it a line of known
/// length to check the printer with, and the strip's parameters.
std::string strip_pdf(const optics::BarCode& code, double height_mm);

}  // namespace shaker::calibration

#pragma once
// A board on paper.
#include <string>

#include "drivers/optics/board.hpp"

namespace shaker::calibration {

/// A PDF of one page: the board at its exact size, a margin of two squares, and a line that states what was
/// printed and which length to measure.
std::string board_pdf(const optics::Board& board);

}  // namespace shaker::calibration

#pragma once
// Pictures of a board as a camera sees it, with exact sub-pixel edges.
#include <cstdint>
#include <vector>

#include "drivers/optics/board.hpp"

namespace shaker::optics {

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

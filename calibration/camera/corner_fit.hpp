#pragma once
// Place of a chess board's corner in a picture, by a model of its grey levels.
#include <array>
#include <optional>

#include "calibration/camera/grey_picture.hpp"

namespace shaker::calibration {

/// Where a corner is expected.
struct ExpectedCorner {
    std::array<double, 2> at_px{};
    std::array<double, 2> x_px{}, y_px{};  // image of the board's x and y over one square
    double quiet_share = 0.15;             // margin around a marker over the square
};

struct FittedCorner {
    std::array<double, 2> at_px{};
    double rms = 0;       // of the grey levels about the model, over its amplitude
    double blur = 0;      // sigma, px
    double reach_px = 0;  // length of either edge that was looked at, to either side
};

/// Fits I(p) = a + g . (p - c) + b erf(d_1 / (sqrt(2) s)) erf(d_2 / (sqrt(2) s)) to the grey levels around
/// the corner c, with d_1, d_2 the distances from its two edges, which may have any angle. A blur that is
/// symmetric does not move c, however large. Pixels that a marker may touch are left out. Empty when the fit
/// does not converge near the expected place, or the levels are not those of a corner.
std::optional<FittedCorner> fit_corner(const GreyPicture& picture, const ExpectedCorner& expected);

}  // namespace shaker::calibration

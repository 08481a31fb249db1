#pragma once
// Exposure and focus of a camera's picture as two figures.
#include <cmath>

#include "drivers/data.hpp"

namespace shaker::web {

struct PictureFigures {
    double clipped = 0;    // share of the pixels at the end of the sensor's range, 0 to 1
    double edge_px = NAN;  // width of the steepest edges along the rows: height / slope, px; NaN: no edge
};

/// From at most 32 rows at full resolution. A sharp step is 2 px wide, one that is blurred by a Gaussian of
/// standard deviation s is about 2.5 s wide. Without pixels: no figures.
PictureFigures figures_of(const Frame& frame);

}  // namespace shaker::web

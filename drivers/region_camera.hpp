#pragma once
// A camera of which only the part is taken that its targets can be in.
#include <memory>
#include <vector>

#include "drivers/devices.hpp"

namespace shaker {

/// What a camera's targets can be in, in whole pictures: along the shaker's axis everything, because that is
/// where they go; across it their regions and half as much again on either side, 16 px at least.
struct PictureRegion {
    int x = 0, y = 0;           // px, its first
    int width = 0, height = 0;  // px; 0: up to the picture's end
};
/// Everything for a view whose axis is neither along rows nor along columns (within 20 degrees) or that has
/// no targets.
PictureRegion region_of(const View& view);

/// Every camera of a rig is replaced by its region. What is tracked and what is kept are then the same
/// pixels, so that a recording of them replays to the bit.
void take_regions(Rig& rig);

}  // namespace shaker

#pragma once
// A camera whose pictures are cropped to the region in which its targets can move.

#include "drivers/devices.hpp"

namespace shaker::bench {

/// Region of a picture that the targets can reach: the full length along the shaker's axis; across it the
/// targets' regions plus half their size on either side, at least 16 px.
struct PictureRegion {
    int x = 0, y = 0;           // px, first column and row
    int width = 0, height = 0;  // px; 0: up to the edge of the picture
};
/// The whole picture for a view without targets, or whose shaker axis is more than 20 degrees off both
/// rows and columns.
PictureRegion region_of(const View& view);

/// Crops every camera of a rig that gives pixels to its region. Tracked and recorded pixels are then the
/// same, and a recording replays to the bit.
void take_regions(Rig& rig);

}  // namespace shaker::bench

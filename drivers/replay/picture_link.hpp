#pragma once
// One HDF5 file in which the pictures of all segments of a camera are one array.
#include "drivers/replay/opened_segment.hpp"

namespace shaker {

/// Writes <folder>/<camera>.h5: /frames and /index as virtual data sets over the segments, which are named
/// relative to it, up to picture number `last`. Pictures without a file read as zeros, and so do their
/// records. DeviceError when it cannot be written; what was there before then stays.
void link_pictures(const std::filesystem::path& folder, const FoundSegments& segments, std::uint64_t last);

}  // namespace shaker

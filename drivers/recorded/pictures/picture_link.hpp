#pragma once
// Writes one HDF5 file that shows the pictures of all segments of a camera as one array.
#include "drivers/recorded/pictures/opened_segment.hpp"

namespace shaker::pictures {

/// Writes <folder>/<camera>.h5: /frames and /index as virtual data sets over the segments (relative names),
/// up to picture number `last`. Pictures without a file, and their records, read as zeros. DeviceError when
/// it cannot be written; an existing file is then kept.
void link_pictures(const std::filesystem::path& folder, const FoundSegments& segments, std::uint64_t last);

}  // namespace shaker::pictures

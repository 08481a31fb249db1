#pragma once
// Pixels and records of pictures in HDF5's words.
#include "drivers/replay/frame_record.hpp"
#include "drivers/replay/h5.hpp"

namespace shaker {

/// HDF5's names for a pixel and for a FrameRecord in a file.
hid_t pixel_type(const FrameShape& shape);
h5::Handle record_type();

}  // namespace shaker

#pragma once
// HDF5 types of pixels and picture records.
#include "drivers/recorded/h5/h5.hpp"
#include "drivers/recorded/pictures/picture_record.hpp"

namespace shaker::pictures {

/// Types of a pixel and of a PictureRecord in a file.
hid_t pixel_type(const PictureShape& shape);
h5::Handle record_type();

}  // namespace shaker::pictures

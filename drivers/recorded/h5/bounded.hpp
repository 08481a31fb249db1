#pragma once
// Reads HDF5 files of unknown origin within their bounds, for any addresses stored in them.
#include "drivers/recorded/h5/h5.hpp"

namespace shaker::h5 {

/// File access properties, for H5F_ACC_RDONLY. Reads at an address outside the file fail. HDF5 1.10's own
/// drivers cache the metadata read last. While the cache is empty its address is "none" too, and a block that
/// a damaged file places at "none" is then copied from a null pointer.
Handle bounded_access();

}  // namespace shaker::h5

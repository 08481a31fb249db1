#pragma once
// How files of unknown origin are read: nothing outside of them, whatever addresses they hold.
#include "drivers/replay/h5.hpp"

namespace shaker::h5 {

/// File access properties, to open with H5F_ACC_RDONLY, whose reads end in an error where an address is not
/// in the file. HDF5 1.10's own drivers keep a copy of the metadata read last. While there is none its
/// address is "none" too, and a block that a damaged file says to be at "none" is then copied from a null
/// pointer.
Handle bounded_access();

}  // namespace shaker::h5

#pragma once
// Our file drivers for HDF5: one reads files of unknown origin within their bounds, for any addresses stored
// in them; the other writes by a WrittenFile (written_file.hpp).
#include <cstddef>

#include "drivers/recorded/h5/h5.hpp"

namespace shaker::h5 {

/// File access properties, for H5F_ACC_RDONLY. Reads at an address outside the file fail. HDF5 1.10's own
/// drivers cache the metadata read last. While the cache is empty its address is "none" too, and a block that
/// a damaged file places at "none" is then copied from a null pointer.
Handle bounded_access();

/// Bytes; 0 when they cannot be determined.
haddr_t length_of(int descriptor);

/// Reads up to the end of the file. Returns the number of bytes read, or -1 and sets errno.
ssize_t read_available(int descriptor, haddr_t from, void* to, std::size_t bytes);

}  // namespace shaker::h5

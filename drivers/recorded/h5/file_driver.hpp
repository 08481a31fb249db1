#pragma once
// Parts of our file drivers for HDF5: errors, comparison and locks of open files.
#include <string>

#include "drivers/recorded/h5/h5.hpp"

namespace shaker::h5 {

/// Adds a message to HDF5's error stack. why: an H5E_ code.
void add_error(const std::string& what, hid_t why);
/// The system's text for an errno.
std::string text_of(int error);

/// HDF5's order of two open files: -1, 0 (the same file) or 1.
int compare(int descriptor, int other);
/// Bytes; 0 when they cannot be determined.
haddr_t length_of(int descriptor);
/// HDF5's own advisory lock. operation: of flock(2). A file system without locks is not an error.
herr_t lock_by_hdf5(int descriptor, int operation);

/// Reads up to the end of the file. Returns the number of bytes read, or -1 and sets errno.
ssize_t read_available(int descriptor, haddr_t from, void* to, std::size_t bytes);

/// Driver without operations: limits, and the kinds of memory as HDF5's default driver has them.
H5FD_class_t empty_driver(const char* name);

}  // namespace shaker::h5

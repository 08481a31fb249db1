#pragma once
// Errors common to opening and reading files of unknown origin: an HDF5 error is the fault of the file.
#include "drivers/recorded/h5/h5.hpp"

namespace shaker::h5 {

/// Throws InputError naming the path.
[[noreturn]] void refuse(const std::string& path, const std::string& why);
/// A handle used for reading only; refuse() when `id` is invalid.
Handle readable(hid_t id, const std::string& path);
void readable(herr_t status, const std::string& path);
/// The reason for which HDF5 did not open `path`.
std::string why_not(hid_t parent, const std::string& path);

}  // namespace shaker::h5

#pragma once
// What reading and opening a file of others have in common: what HDF5 cannot do is the file's fault.
#include "drivers/replay/h5.hpp"

namespace shaker::h5 {

/// Throws InputError naming the path.
[[noreturn]] void refuse(const std::string& path, const std::string& why);
/// A handle that is only read through.
Handle readable(hid_t id, const std::string& path);
void readable(herr_t status, const std::string& path);
/// Why HDF5 did not open what `path` names.
std::string why_not(hid_t parent, const std::string& path);

}  // namespace shaker::h5

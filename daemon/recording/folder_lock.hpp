#pragma once
// One daemon records into a folder.
#include <filesystem>

#include "drivers/recorded/h5/file_lock.hpp"

namespace shaker::recording {

/// Name of the locked file in the folder. The file stays; the lock ends with its process.
inline constexpr const char* folder_lock_name = ".shakerd.lock";

/// Locks a folder for a daemon's recordings. InputError, which names the other process, when another daemon
/// has the folder; DeviceError when the folder cannot be written.
h5::FileLock lock_folder(const std::filesystem::path& folder);

}  // namespace shaker::recording

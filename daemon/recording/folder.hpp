#pragma once
// The folder of recordings: one daemon records into it, and its disk needs space.
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <string>

#include "drivers/recorded/h5/file_lock.hpp"
#include "drivers/recorded/recording_file.hpp"

namespace shaker::recording {

/// Rates of the newest complete recording.
struct RecordedRate {
    double bytes_per_s = NAN;     // without pictures; NaN: no recording was completed yet
    double pictures_per_s = NAN;  // bytes of its pictures per second
    recorded::KeptPictures pictures{};
    double lasted_s = NAN;  // its length; NaN: not known
};

/// Name of the locked file in the folder. The file stays; the lock ends with its process.
inline constexpr const char* folder_lock_name = ".shakerd.lock";

/// Locks a folder for a daemon's recordings. InputError, which names the other process, when another daemon
/// has the folder; DeviceError when the folder cannot be written.
h5::FileLock lock_folder(const std::filesystem::path& folder);

/// "1.07 GB".
std::string gigabytes(std::uint64_t bytes);
/// DeviceError when the disk does not answer.
std::uint64_t free_bytes(const std::filesystem::path& file);
/// InputError if less than `stays` + `taken` bytes are free. taken: by the first pictures.
void require_space(const std::filesystem::path& file, std::uint64_t stays, std::uint64_t taken);

}  // namespace shaker::recording

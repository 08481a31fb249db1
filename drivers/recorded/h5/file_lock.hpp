#pragma once
// FileLock: an advisory lock on a file or folder. Also gives files their final names without replacing
// others.
#include <sys/types.h>

#include <filesystem>
#include <optional>

#include "drivers/descriptor.hpp"

namespace shaker::h5 {

enum class Sharing { alone, shared };

/// The lock ends with this object, or with the process, however it ends. On a file system without locks
/// nothing is locked and held() is false.
class FileLock {
public:
    FileLock() = default;
    /// Creates the file and locks it. InputError when the file exists, DeviceError when it cannot be created.
    static FileLock of_new(const std::filesystem::path& file);
    /// Locks an existing file, or one that this call creates (`make`). Empty when another process or object
    /// has the lock. InputError when the file is missing, DeviceError when it cannot be opened.
    static std::optional<FileLock> take(const std::filesystem::path& file, bool make = false);
    /// Locks a folder, alone or together with others that share it. Empty when it is locked in a way that
    /// excludes this. InputError when it is missing or a link, DeviceError when it cannot be opened.
    static std::optional<FileLock> take_folder(const std::filesystem::path& folder, Sharing sharing);

    [[nodiscard]] bool held() const noexcept { return held_; }
    /// False when the locked file has been renamed or removed since it was opened as `file`.
    [[nodiscard]] bool is_still(const std::filesystem::path& file) const noexcept;

private:
    Descriptor fd_;
    bool held_ = false;
};

/// The process that has locked a file; empty for a file that is not locked, or missing.
std::optional<pid_t> locked_by(const std::filesystem::path& file) noexcept;

/// Renames a file or a folder. InputError, which names both, when `to` exists; DeviceError when the disk
/// fails. The folder above is not synchronised.
void rename_new(const std::filesystem::path& from, const std::filesystem::path& to);

}  // namespace shaker::h5

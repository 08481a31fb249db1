#pragma once
// Files and folders that are made before a confined child starts, which may write them and nothing else.
#include <filesystem>

#include "drivers/descriptor.hpp"
#include "drivers/recorded/h5/file_lock.hpp"

namespace shaker::sandbox {

/// A folder, created if it does not exist and `file`, which is read, does. Removed again if it is left empty.
class NewFolder {
public:
    NewFolder(const std::filesystem::path& file, std::filesystem::path folder);
    ~NewFolder();
    NewFolder(const NewFolder&) = delete;
    NewFolder& operator=(const NewFolder&) = delete;

private:
    std::filesystem::path folder_;
    bool made_ = false;
};

/// A file that did not exist, open for writing. Removed again if it is left empty.
class NewFile {
public:
    /// Throws InputError when a file or link has this name, DeviceError when the file cannot be created.
    explicit NewFile(std::filesystem::path file);
    ~NewFile();
    NewFile(const NewFile&) = delete;
    NewFile& operator=(const NewFile&) = delete;

    [[nodiscard]] int descriptor() const noexcept { return fd_; }

private:
    std::filesystem::path file_;
    Descriptor fd_;
};

/// A recording that is written in a folder of its own beside its name, FILE.unfinished.
class NewRecording {
public:
    /// Creates the folder, for this user only, and locks it. A folder that a killed program has left is
    /// emptied. Throws InputError when another program has locked it, or it cannot be created.
    explicit NewRecording(std::filesystem::path file);
    /// Removes the folder, unless keep() was called.
    ~NewRecording();
    NewRecording(const NewRecording&) = delete;
    NewRecording& operator=(const NewRecording&) = delete;

    [[nodiscard]] const std::filesystem::path& folder() const noexcept { return folder_; }
    /// Path for the recording in the folder.
    [[nodiscard]] std::filesystem::path working() const;
    /// Moves the recording with its pictures and its journal to its name. Nothing is replaced: throws
    /// DeviceError, and all of it stays in the folder, which the message names.
    void keep();

private:
    std::filesystem::path file_, folder_;
    h5::FileLock lock_;
    bool complete_ = false;
};

}  // namespace shaker::sandbox

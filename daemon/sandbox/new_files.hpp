#pragma once
// Files and folders that exist before a confined child gets the right to write them, and to write nothing
// else.
#include <filesystem>

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

/// A file, created if it does not exist. Removed again if it is left empty. An empty path is no file.
class NewFile {
public:
    explicit NewFile(std::filesystem::path file);
    ~NewFile();
    NewFile(const NewFile&) = delete;
    NewFile& operator=(const NewFile&) = delete;

private:
    std::filesystem::path file_;
    bool made_ = false;
};

/// A recording that is written in a folder of its own beside its name, FILE.unfinished.
class NewRecording {
public:
    /// Creates the folder, for this user only. Throws InputError when it exists or cannot be created.
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
    bool complete_ = false;
};

}  // namespace shaker::sandbox

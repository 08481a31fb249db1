#pragma once
// Opens and changes files for a process that may not do it itself.
#include <sys/types.h>

#include <filesystem>
#include <string>
#include <vector>

#include "daemon/sandbox/file_rights.hpp"

namespace shaker::sandbox {

/// The files of FileRights, for a kernel that does not check them. A path is resolved here: below a folder
/// that is allowed no link leads out of it. Answers are those of system calls: 0 or more, or a negative
/// errno; -EACCES for a file that is not allowed. One thread.
class AllowedFiles {
public:
    explicit AllowedFiles(const FileRights& allowed);

    /// A descriptor for open(path, flags, mode) by the process `pid`, whose /proc/self is meant.
    [[nodiscard]] int open(pid_t pid, const std::string& path, int flags, mode_t mode) const;
    [[nodiscard]] int make_folder(const std::string& path, mode_t mode) const;
    [[nodiscard]] int remove(const std::string& path, int flags) const;
    [[nodiscard]] int rename(const std::string& from, const std::string& to, unsigned flags) const;
    [[nodiscard]] int link(const std::string& from, const std::string& to) const;

private:
    enum class Use { list, read, write };
    struct Root {
        std::filesystem::path path;  // absolute
        Use most;
    };
    struct Place;

    [[nodiscard]] const Root* root_of(const std::filesystem::path& path, Use use) const;
    [[nodiscard]] Place place_of(const std::string& path) const;

    std::vector<Root> roots_;
};

}  // namespace shaker::sandbox

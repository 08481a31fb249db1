#include "daemon/sandbox/allowed_files.hpp"

#include <fcntl.h>
#include <linux/openat2.h>
#include <spdlog/fmt/fmt.h>
#include <stdio.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>

#include "daemon/sandbox/descriptor.hpp"

namespace shaker::sandbox {

namespace {

namespace fs = std::filesystem;

const fs::path own_state = "/proc/self";

// Without "..", "." and a slash at the end; empty for an empty path.
fs::path plain(const fs::path& path) {
    if (path.empty()) return {};
    fs::path whole = fs::absolute(path).lexically_normal();
    return whole.has_filename() || whole == whole.root_path() ? whole : whole.parent_path();
}

bool is_below(const fs::path& path, const fs::path& root) {
    return std::mismatch(root.begin(), root.end(), path.begin(), path.end()).first == root.end();
}

int answer(long result) { return result < 0 ? -errno : static_cast<int>(result); }

// Opens a path below a folder; links that lead out of the folder are refused.
int open_below(int folder, const fs::path& rest, int flags, mode_t mode) {
    open_how how{};
    how.flags = static_cast<std::uint64_t>(flags);
    how.mode = (flags & (O_CREAT | O_TMPFILE)) != 0 ? mode : 0;
    how.resolve = RESOLVE_BENEATH | RESOLVE_NO_MAGICLINKS;
    const int opened = answer(::syscall(SYS_openat2, folder, rest.c_str(), &how, sizeof how));
    return opened == -EXDEV || opened == -ELOOP ? -EACCES : opened;
}

// A file of the process that has no name any more. Others could be reopened with more rights than it has.
int reopen(const fs::path& link, int flags) {
    const Descriptor there{::open(link.c_str(), O_PATH | O_CLOEXEC)};
    struct stat status {};
    if (there.get() < 0 || ::fstat(there.get(), &status) < 0) return -errno;
    if (!S_ISREG(status.st_mode) || status.st_nlink != 0) return -EACCES;
    return answer(::open(link.c_str(), flags));
}

}  // namespace

/// A name in a folder that is open.
struct AllowedFiles::Place {
    Descriptor folder;
    std::string name;
    int error = 0;
};

AllowedFiles::AllowedFiles(const FileRights& allowed) {
    const auto add = [&](const auto& paths, Use most) {
        for (const auto& path : paths) roots_.push_back({plain(path), most});
    };
    add(system_files(), Use::read);
    add(allowed.lists, Use::list);
    add(allowed.reads, Use::read);
    add(allowed.writes, Use::write);
}

const AllowedFiles::Root* AllowedFiles::root_of(const fs::path& path, Use use) const {
    const auto found = std::ranges::find_if(
        roots_, [&](const Root& root) { return root.most >= use && is_below(path, root.path); });
    return found == roots_.end() ? nullptr : &*found;
}

int AllowedFiles::open(pid_t pid, const std::string& path, int flags, mode_t mode) const {
    const bool writes = (flags & O_ACCMODE) != O_RDONLY || (flags & (O_CREAT | O_TRUNC)) != 0;
    const bool lists = (flags & O_DIRECTORY) != 0 && (flags & O_TMPFILE) != O_TMPFILE;
    // A FIFO must not hold up this process, and a terminal not become its own.
    const int own_flags = flags | O_CLOEXEC | O_NONBLOCK | O_NOCTTY;
    const fs::path wanted = plain(path);
    int opened = -EACCES;
    if (is_below(wanted, own_state / "fd") && wanted != own_state / "fd")
        return reopen(fmt::format("/proc/{}/fd/{}", pid, wanted.filename().string()), own_flags & ~O_CREAT);
    const Root* root = root_of(wanted, writes ? Use::write : lists ? Use::list : Use::read);
    if (root == nullptr) return opened;
    const fs::path there = root->path == own_state ? fs::path{fmt::format("/proc/{}", pid)} : root->path;
    if (wanted == root->path) {
        opened = answer(::open(there.c_str(), own_flags, mode));
    } else {
        const Descriptor folder{::open(there.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC)};
        if (folder.get() < 0) return -errno;
        opened = open_below(folder.get(), wanted.lexically_relative(root->path), own_flags, mode);
    }
    if (opened >= 0 && (flags & O_NONBLOCK) == 0) ::fcntl(opened, F_SETFL, flags & ~O_NONBLOCK);
    return opened;
}

AllowedFiles::Place AllowedFiles::place_of(const std::string& path) const {
    const fs::path wanted = plain(path);
    const Root* root = root_of(wanted, Use::write);
    if (root == nullptr || wanted == root->path) return {Descriptor{-1}, {}, -EACCES};
    const Descriptor above{::open(root->path.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC)};
    if (above.get() < 0) return {Descriptor{-1}, {}, -errno};
    const int folder =
        open_below(above.get(), fs::path{"."} / wanted.parent_path().lexically_relative(root->path),
                   O_PATH | O_DIRECTORY | O_CLOEXEC, 0);
    return {Descriptor{folder}, wanted.filename().string(), std::min(folder, 0)};
}

int AllowedFiles::make_folder(const std::string& path, mode_t mode) const {
    const Place place = place_of(path);
    if (place.error != 0) return place.error;
    return answer(::mkdirat(place.folder.get(), place.name.c_str(), mode));
}

int AllowedFiles::remove(const std::string& path, int flags) const {
    const Place place = place_of(path);
    if (place.error != 0) return place.error;
    return answer(::unlinkat(place.folder.get(), place.name.c_str(), flags));
}

int AllowedFiles::rename(const std::string& from, const std::string& to, unsigned flags) const {
    const Place old = place_of(from), fresh = place_of(to);
    if (old.error != 0 || fresh.error != 0) return std::min(old.error, fresh.error);
    return answer(
        ::renameat2(old.folder.get(), old.name.c_str(), fresh.folder.get(), fresh.name.c_str(), flags));
}

int AllowedFiles::link(const std::string& from, const std::string& to) const {
    const Place old = place_of(from), fresh = place_of(to);
    if (old.error != 0 || fresh.error != 0) return std::min(old.error, fresh.error);
    return answer(::linkat(old.folder.get(), old.name.c_str(), fresh.folder.get(), fresh.name.c_str(), 0));
}

}  // namespace shaker::sandbox

// Logs all changes that a program makes to the files of a folder, in the order of their effect.
// SHAKER_DISK_FOLDER names the folder, SHAKER_DISK_LOG the log. A write is logged before the program
// continues, so writes are made one by one. After SHAKER_DISK_KILL entries SIGKILL ends the program. The
// calls of its child processes are not logged.
#include "tests/support/recording/disk_log.hpp"

#include <fcntl.h>
#include <sys/uio.h>

#include <csignal>
#include <cstdarg>
#include <cstdlib>
#include <mutex>

#include "tests/preload/interposed.hpp"

namespace {

using namespace shaker::interposed;
using shaker::test::DiskCall;
using shaker::test::DiskEntry;

std::mutex& in_order() {
    static std::mutex mutex;
    return mutex;
}

int log_file() {
    static const int descriptor = [] {
        const char* name = std::getenv("SHAKER_DISK_LOG");
        if (name == nullptr) std::abort();
        return real<int(const char*, int, ...)>("open")(name, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
    }();
    return descriptor;
}

std::uint64_t entries = 0;

// A confined child process has no log.
const pid_t program = ::getpid();

// 0: no kill.
std::uint64_t last_entry() {
    static const std::uint64_t last = [] {
        const char* set = std::getenv("SHAKER_DISK_KILL");
        return set == nullptr ? 0 : std::strtoull(set, nullptr, 10);
    }();
    return last;
}

std::uint64_t inode_of(int descriptor) {
    struct stat status {};
    return ::fstat(descriptor, &status) == 0 ? status.st_ino : 0;
}

// The caller holds in_order().
void tell(DiskEntry entry, const std::string& name = {}, const std::string& second = {},
          const void* data = nullptr) {
    if (::getpid() != program) return;
    const int before = errno;
    entry.name_bytes = static_cast<std::uint32_t>(name.size());
    entry.second_bytes = static_cast<std::uint32_t>(second.size());
    const auto part = [](const void* at, std::size_t n) { return iovec{const_cast<void*>(at), n}; };
    const std::array parts{part(&entry, sizeof entry), part(name.data(), name.size()),
                           part(second.data(), second.size()), part(data, entry.bytes)};
    const auto whole = static_cast<ssize_t>(sizeof entry + name.size() + second.size() + entry.bytes);
    if (::writev(log_file(), parts.data(), static_cast<int>(parts.size())) != whole) std::abort();
    if (++entries == last_entry()) ::kill(::getpid(), SIGKILL);
    errno = before;
}

DiskEntry entry(DiskCall call, int descriptor, std::int64_t at = 0, std::uint64_t bytes = 0) {
    return {call, 0, 0, 0, inode_of(descriptor), at, 0, bytes};
}

template <class Write>
ssize_t logged_write(int descriptor, const void* data, Write write) {
    const std::scoped_lock lock{in_order()};
    std::int64_t at = 0;
    const ssize_t n = write(at);
    if (n > 0) tell(entry(DiskCall::write, descriptor, at, static_cast<std::uint64_t>(n)), {}, {}, data);
    return n;
}

int logged_sync(int descriptor, const char* call) {
    auto* const sync = real<int(int)>(call);
    const std::string name = meant(descriptor);
    if (name.empty()) return sync(descriptor);
    std::uint64_t covered = 0;
    {
        const std::scoped_lock lock{in_order()};
        covered = entries;
    }
    const int result = sync(descriptor);
    if (result != 0) return result;
    struct stat status {};
    const bool folder = ::fstat(descriptor, &status) == 0 && S_ISDIR(status.st_mode);
    const std::scoped_lock lock{in_order()};
    DiskEntry done = entry(folder ? DiskCall::sync_folder : DiskCall::sync, descriptor);
    done.covered = covered;
    tell(done, name);
    return result;
}

template <class Change>
int logged_name(DiskCall call, const char* path, const char* second, Change change) {
    const std::string name = absolute(path), other = second == nullptr ? std::string{} : absolute(second);
    if (!is_meant(name)) return change();
    const std::scoped_lock lock{in_order()};
    const int result = change();
    if (result == 0) tell({call, 0, 0, 0, 0, 0, 0, 0}, name, other);
    return result;
}

}  // namespace

extern "C" {

int open(const char* path, int flags, ...) {
    va_list more;
    va_start(more, flags);
    const mode_t mode = (flags & O_CREAT) != 0 ? va_arg(more, mode_t) : 0;
    va_end(more);
    auto* const next = real<int(const char*, int, ...)>("open");
    if ((flags & (O_CREAT | O_TRUNC)) == 0 || folder().empty() || !is_meant(absolute(path)))
        return next(path, flags, mode);
    const std::scoped_lock lock{in_order()};
    const bool there = ::access(path, F_OK) == 0;
    const int descriptor = next(path, flags, mode);
    if (descriptor >= 0 && !there) tell(entry(DiskCall::create, descriptor), absolute(path));
    if (descriptor >= 0 && there && (flags & O_TRUNC) != 0) tell(entry(DiskCall::size, descriptor));
    return descriptor;
}

ssize_t pwrite(int descriptor, const void* data, size_t bytes, off_t at) {
    auto* const next = real<ssize_t(int, const void*, size_t, off_t)>("pwrite");
    if (meant(descriptor).empty()) return next(descriptor, data, bytes, at);
    return logged_write(descriptor, data, [&](std::int64_t& where) {
        where = at;
        return next(descriptor, data, bytes, at);
    });
}

ssize_t write(int descriptor, const void* data, size_t bytes) {
    auto* const next = real<ssize_t(int, const void*, size_t)>("write");
    if (meant(descriptor).empty()) return next(descriptor, data, bytes);
    return logged_write(descriptor, data, [&](std::int64_t& where) {
        const ssize_t n = next(descriptor, data, bytes);
        if (n > 0) where = ::lseek(descriptor, 0, SEEK_CUR) - n;
        return n;
    });
}

int ftruncate(int descriptor, off_t bytes) noexcept {
    auto* const next = real<int(int, off_t)>("ftruncate");
    if (meant(descriptor).empty()) return next(descriptor, bytes);
    const std::scoped_lock lock{in_order()};
    const int result = next(descriptor, bytes);
    if (result == 0) tell(entry(DiskCall::size, descriptor, bytes));
    return result;
}

int posix_fallocate(int descriptor, off_t at, off_t bytes) {
    auto* const next = real<int(int, off_t, off_t)>("posix_fallocate");
    if (meant(descriptor).empty()) return next(descriptor, at, bytes);
    const std::scoped_lock lock{in_order()};
    const int result = next(descriptor, at, bytes);
    if (result == 0) tell(entry(DiskCall::reserve, descriptor, at + bytes));
    return result;
}

int fdatasync(int descriptor) { return logged_sync(descriptor, "fdatasync"); }
int fsync(int descriptor) { return logged_sync(descriptor, "fsync"); }

int rename(const char* from, const char* to) noexcept {
    return logged_name(DiskCall::rename, from, to,
                       [&] { return real<int(const char*, const char*)>("rename")(from, to); });
}
int renameat2(int from_folder, const char* from, int to_folder, const char* to, unsigned flags) noexcept {
    return logged_name(DiskCall::rename, from, to, [&] {
        return real<int(int, const char*, int, const char*, unsigned)>("renameat2")(from_folder, from,
                                                                                    to_folder, to, flags);
    });
}
int unlink(const char* path) noexcept {
    return logged_name(DiskCall::remove, path, nullptr,
                       [&] { return real<int(const char*)>("unlink")(path); });
}
int remove(const char* path) noexcept {
    return logged_name(DiskCall::remove, path, nullptr,
                       [&] { return real<int(const char*)>("remove")(path); });
}
int mkdir(const char* path, mode_t mode) noexcept {
    return logged_name(DiskCall::folder, path, nullptr,
                       [&] { return real<int(const char*, mode_t)>("mkdir")(path, mode); });
}

}  // extern "C"

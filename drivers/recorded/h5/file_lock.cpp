#include "drivers/recorded/h5/file_lock.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <system_error>

#include "drivers/errors.hpp"

namespace shaker::h5 {

namespace {

// A lock of an open file does not have the number of its process, so its length does: this plus the number.
constexpr off_t least_length = off_t{1} << 40;

struct flock whole_file(short type) {
    struct flock lock {};
    lock.l_type = type;
    lock.l_whence = SEEK_SET;
    lock.l_len = least_length + ::getpid();
    return lock;
}

Descriptor descriptor_of(const std::filesystem::path& file, int flags) {
    constexpr mode_t mode = 0666;  // reduced by the process's umask
    int fd = -1;
    if ((flags & O_CREAT) != 0) flags |= O_NOFOLLOW;
    do fd = ::open(file.c_str(), flags | O_CLOEXEC | O_NONBLOCK, mode);  // a FIFO does not block either
    while (fd < 0 && errno == EINTR);
    return Descriptor{fd};
}

enum class Locked { yes, no, by_another };

Locked lock(int fd, const std::filesystem::path& file) {
    // A file that may only be read takes a shared lock, which a writer's lock excludes too.
    const bool writes = (::fcntl(fd, F_GETFL) & O_ACCMODE) != O_RDONLY;
    struct flock wanted = whole_file(writes ? F_WRLCK : F_RDLCK);
    if (::fcntl(fd, F_OFD_SETLK, &wanted) == 0) return Locked::yes;
    const int error = errno;
    if (error == EAGAIN || error == EACCES) return Locked::by_another;
    if (error == ENOLCK || error == EINVAL || error == EOPNOTSUPP || error == ENOSYS) return Locked::no;
    throw DeviceError{file.string() + ": cannot be locked: " + system_text(error)};
}

// For a file system that cannot do it in one step. A folder takes the place of an empty one, which no other
// program has made.
bool rename_in_steps(const char* from, const char* to) {
    struct stat status {};
    if (::lstat(from, &status) < 0) return false;
    if (!S_ISDIR(status.st_mode)) return ::link(from, to) == 0 && ::unlink(from) == 0;
    if (::mkdir(to, S_IRWXU) < 0) return false;
    if (::rename(from, to) == 0) return true;
    const int error = errno;
    ::rmdir(to);
    errno = error;
    return false;
}

[[noreturn]] void refuse_existing(const std::filesystem::path& file) {
    throw InputError{file.string() + ": exists already; recordings are never overwritten"};
}

}  // namespace

FileLock FileLock::of_new(const std::filesystem::path& file) {
    FileLock made;
    made.fd_ = descriptor_of(file, O_RDWR | O_CREAT | O_EXCL);
    if (made.fd_ < 0 && errno == EEXIST) refuse_existing(file);
    if (made.fd_ < 0) throw DeviceError{file.string() + ": cannot be created: " + system_text(errno)};
    const Locked locked = lock(made.fd_, file);
    if (locked == Locked::by_another)
        throw DeviceError{file.string() + ": was locked by another process as soon as it was created"};
    made.held_ = locked == Locked::yes;
    return made;
}

std::optional<FileLock> FileLock::take(const std::filesystem::path& file, bool make) {
    FileLock taken;
    taken.fd_ = descriptor_of(file, O_RDWR | (make ? O_CREAT : 0));
    if (taken.fd_ < 0 && (errno == EACCES || errno == EROFS || errno == EPERM))
        taken.fd_ = descriptor_of(file, O_RDONLY);
    if (taken.fd_ < 0 && errno == ENOENT && !make) throw InputError{file.string() + ": no such file"};
    if (taken.fd_ < 0) throw DeviceError{file.string() + ": cannot be opened: " + system_text(errno)};
    const Locked locked = lock(taken.fd_, file);
    if (locked == Locked::by_another) return std::nullopt;
    taken.held_ = locked == Locked::yes;
    return taken;
}

// A folder cannot be opened for writing, which fcntl's lock for one process needs.
std::optional<FileLock> FileLock::take_folder(const std::filesystem::path& folder, Sharing sharing) {
    FileLock taken;
    taken.fd_ = descriptor_of(folder, O_RDONLY | O_DIRECTORY | O_NOFOLLOW);
    if (taken.fd_ < 0 && (errno == ENOTDIR || errno == ELOOP || errno == ENOENT))
        throw InputError{folder.string() + ": is a link or not a folder; a folder was expected"};
    if (taken.fd_ < 0) throw DeviceError{folder.string() + ": cannot be opened: " + system_text(errno)};
    const int how = sharing == Sharing::alone ? LOCK_EX : LOCK_SH;
    taken.held_ = ::flock(taken.fd_, how | LOCK_NB) == 0;
    if (!taken.held_ && errno == EWOULDBLOCK) return std::nullopt;
    return taken;
}

bool FileLock::is_still(const std::filesystem::path& file) const noexcept {
    struct stat opened {
    }, named{};
    return ::fstat(fd_, &opened) == 0 && ::stat(file.c_str(), &named) == 0 && opened.st_dev == named.st_dev &&
           opened.st_ino == named.st_ino;
}

std::optional<pid_t> locked_by(const std::filesystem::path& file) noexcept {
    std::error_code unknown;
    if (!std::filesystem::exists(file, unknown)) return std::nullopt;
    const Descriptor fd = descriptor_of(file, O_RDONLY);
    if (fd < 0) return std::nullopt;
    struct flock found = whole_file(F_WRLCK);
    found.l_pid = 0;
    const bool asked = ::fcntl(fd, F_OFD_GETLK, &found) == 0;
    if (!asked || found.l_type == F_UNLCK) return std::nullopt;
    return found.l_len > least_length ? static_cast<pid_t>(found.l_len - least_length) : pid_t{0};
}

void rename_new(const std::filesystem::path& from, const std::filesystem::path& to) {
    if (::renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_NOREPLACE) == 0) return;
    int error = errno;
    if (error == EINVAL || error == ENOSYS) {
        if (rename_in_steps(from.c_str(), to.c_str())) return;
        error = errno;
    }
    if (error == EEXIST)
        throw InputError{from.string() + " cannot be renamed to " + to.string() +
                         ": another file has this name; nothing is overwritten"};
    throw DeviceError{from.string() + ": cannot be renamed to " + to.string() + ": " + system_text(error)};
}

}  // namespace shaker::h5

#include "drivers/recorded/h5/disk_file.hpp"

#include <fcntl.h>
#include <spdlog/fmt/fmt.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <utility>

#include "drivers/errors.hpp"
#include "drivers/recorded/h5/file_lock.hpp"

namespace shaker::h5 {

namespace {

/// Result of a system call, repeated after EINTR.
template <class Call>
auto uninterrupted(Call call) {
    auto value = call();
    while (value < 0 && errno == EINTR) value = call();
    return value;
}

double megabytes(std::uint64_t bytes) { return static_cast<double>(bytes) / 1e6; }

}  // namespace

DiskFile::DiskFile(std::filesystem::path path, int flags) : path_{std::move(path)} {
    constexpr mode_t mode = 0666;  // reduced by the process's umask
    fd_ = Descriptor{uninterrupted([&] { return ::open(path_.c_str(), flags | O_CLOEXEC, mode); })};
    if (fd_ < 0 && errno == ENOENT && (flags & O_CREAT) == 0)
        throw InputError{path_.string() + ": no such file"};
    if (fd_ < 0) fail("cannot be opened", errno);
}

DiskFile DiskFile::create(const std::filesystem::path& file) {
    if (::unlink(file.c_str()) < 0 && errno != ENOENT)
        throw DeviceError{file.string() + ": cannot be replaced: " + system_text(errno)};
    DiskFile made{file, O_RDWR | O_CREAT | O_EXCL};
    const auto again = [&](int flags) {
        return Descriptor{
            uninterrupted([&] { return ::open(file.c_str(), O_WRONLY | O_CLOEXEC | O_NOFOLLOW | flags); })};
    };
    made.pages_fd_ = again(O_DIRECT);
    made.direct_ = made.pages_fd_ >= 0;
    if (!made.direct_ && errno == EINVAL) made.pages_fd_ = again(0);
    if (made.pages_fd_ < 0) made.fail("cannot be opened", errno);
    return made;
}

DiskFile DiskFile::open(const std::filesystem::path& file) { return {file, O_RDONLY}; }

void DiskFile::fail(const std::string& what, int error) const {
    throw DeviceError{path_.string() + ": " + what + ": " + system_text(error)};
}

std::uint64_t DiskFile::size() const {
    struct stat status {};
    if (::fstat(fd_, &status) < 0) fail("has no size", errno);
    return static_cast<std::uint64_t>(status.st_size);
}

void DiskFile::reserve(std::uint64_t bytes) {
    struct statvfs disk {};
    if (::fstatvfs(fd_, &disk) < 0) fail("the free space of its disk is unknown", errno);
    const std::uint64_t free = std::uint64_t{disk.f_bavail} * disk.f_frsize;
    // A disk that reports nothing (0 blocks in total) is tried. One with too little space is not filled
    // first: other programs write to it.
    int error = disk.f_blocks > 0 && free < bytes ? ENOSPC : EINTR;
    while (error == EINTR) error = ::posix_fallocate(fd_, 0, static_cast<off_t>(bytes));
    if (error == ENOSPC)
        throw DeviceError{fmt::format("{}: no space for {}: {:.1f} MB required, {:.1f} MB free: {}",
                                      path_.parent_path().string(), path_.filename().string(),
                                      megabytes(bytes), megabytes(free), system_text(error))};
    if (error != 0) fail(fmt::format("{:.1f} MB cannot be reserved", megabytes(bytes)), error);
}

void DiskFile::write_all(int to, std::uint64_t at, std::span<const std::byte> bytes) {
    while (!bytes.empty()) {
        const ssize_t n =
            uninterrupted([&] { return ::pwrite(to, bytes.data(), bytes.size(), static_cast<off_t>(at)); });
        if (n < 0 && errno == EINVAL && to == pages_fd_ && direct_) {
            // Some file systems accept O_DIRECT and then require larger units.
            direct_ = false;
            if (::fcntl(pages_fd_, F_SETFL, 0) < 0) fail("cannot be written", errno);
            continue;
        }
        if (n < 0) fail(fmt::format("cannot be written at byte {}", at), errno);
        if (n == 0) fail(fmt::format("cannot be written at byte {}", at), ENOSPC);
        bytes = bytes.subspan(static_cast<std::size_t>(n));
        at += static_cast<std::uint64_t>(n);
    }
}

void DiskFile::write(std::uint64_t at, std::span<const std::byte> bytes) { write_all(fd_, at, bytes); }

void DiskFile::write_pages(std::uint64_t at, std::span<const std::byte> pages) {
    write_all(pages_fd_, at, pages);
    if (!direct_) push_out(at, pages.size());
}

void DiskFile::push_out(std::uint64_t at, std::uint64_t bytes) {
    const auto pass = [&](std::uint64_t from, std::uint64_t count, unsigned flags) {
        if (uninterrupted([&] {
                return ::sync_file_range(pages_fd_, static_cast<off_t>(from), static_cast<off_t>(count),
                                         flags);
            }) < 0)
            fail(fmt::format("cannot be written back at byte {}", from), errno);
    };
    pass(at, bytes, SYNC_FILE_RANGE_WRITE);
    if (last_bytes_ > 0) {
        pass(last_at_, last_bytes_,
             SYNC_FILE_RANGE_WAIT_BEFORE | SYNC_FILE_RANGE_WRITE | SYNC_FILE_RANGE_WAIT_AFTER);
        const int error = ::posix_fadvise(pages_fd_, static_cast<off_t>(last_at_),
                                          static_cast<off_t>(last_bytes_), POSIX_FADV_DONTNEED);
        if (error != 0) fail("its pages cannot be dropped from the cache", error);
    }
    last_at_ = at;
    last_bytes_ = bytes;
}

void DiskFile::read(std::uint64_t at, std::span<std::byte> bytes) const {
    while (!bytes.empty()) {
        const ssize_t n =
            uninterrupted([&] { return ::pread(fd_, bytes.data(), bytes.size(), static_cast<off_t>(at)); });
        if (n < 0) fail(fmt::format("cannot be read at byte {}", at), errno);
        if (n == 0) throw InputError{fmt::format("{}: ends before byte {}", path_.string(), at)};
        bytes = bytes.subspan(static_cast<std::size_t>(n));
        at += static_cast<std::uint64_t>(n);
    }
}

void DiskFile::forget() const {
    const int error = ::posix_fadvise(fd_, 0, 0, POSIX_FADV_DONTNEED);
    if (error != 0) fail("its pages cannot be dropped from the cache", error);
}

void DiskFile::sync() {
    if (uninterrupted([&] { return ::fdatasync(fd_); }) < 0)
        fail("cannot be synchronised to the disk", errno);
}

void DiskFile::rename(const std::filesystem::path& to, Existing existing) {
    if (existing == Existing::keep)
        rename_new(path_, to);
    else if (::rename(path_.c_str(), to.c_str()) < 0)
        fail("cannot be renamed to " + to.filename().string(), errno);
    path_ = to;
    sync_folder(to.parent_path());
}

void release(const std::filesystem::path& file, std::uint64_t from) {
    const Descriptor fd{::open(file.c_str(), O_WRONLY | O_CLOEXEC)};
    if (fd < 0) throw DeviceError{file.string() + ": cannot be opened: " + system_text(errno)};
    const off_t at = static_cast<off_t>(whole_pages(from)), end = ::lseek(fd, 0, SEEK_END);
    if (end <= at) return;
    if (uninterrupted(
            [&] { return ::fallocate(fd, FALLOC_FL_PUNCH_HOLE | FALLOC_FL_KEEP_SIZE, at, end - at); }) < 0 &&
        errno != EOPNOTSUPP)
        throw DeviceError{file.string() + ": its unused space cannot be released: " + system_text(errno)};
}

void sync_folder(const std::filesystem::path& folder) {
    const std::filesystem::path name = folder.empty() ? "." : folder;
    const Descriptor fd{
        uninterrupted([&] { return ::open(name.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC); })};
    const int error = fd < 0 || uninterrupted([&] { return ::fsync(fd); }) < 0 ? errno : 0;
    if (error != 0)
        throw DeviceError{name.string() + ": cannot be synchronised to the disk: " + system_text(error)};
}

void replace_file(const std::filesystem::path& file, std::span<const std::byte> bytes) {
    DiskFile fresh = DiskFile::create(unfinished(file));
    fresh.write(0, bytes);
    fresh.sync();
    fresh.rename(file, DiskFile::Existing::replace);
}

std::filesystem::path unfinished(const std::filesystem::path& file) { return file.string() + ".part"; }

}  // namespace shaker::h5

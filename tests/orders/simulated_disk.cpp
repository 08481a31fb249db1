#include "tests/orders/simulated_disk.hpp"

#include <dlfcn.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>

namespace shaker::orders {

namespace {
std::atomic<Disk> disk{Disk::good};
}  // namespace

bool disk_can_fail() noexcept { return SHAKER_SANITIZED == 0; }
void set_disk(Disk now) noexcept { disk = now; }

}  // namespace shaker::orders

#if !SHAKER_SANITIZED

namespace {

using shaker::orders::Disk;

// The C library's own function.
template <class Function>
Function* next(const char* name) {
    return reinterpret_cast<Function*>(::dlsym(RTLD_NEXT, name));
}

// True when a call that changes a file must fail; sets errno.
bool fails() noexcept {
    switch (shaker::orders::disk) {
        case Disk::good:
            return false;
        case Disk::full:
            errno = ENOSPC;
            return true;
        case Disk::failing:
            errno = EIO;
            return true;
    }
    return false;
}

}  // namespace

extern "C" {

ssize_t pwrite64(int file, const void* bytes, size_t count, off64_t at) {
    static auto* const real = next<ssize_t(int, const void*, size_t, off64_t)>("pwrite64");
    return fails() ? -1 : real(file, bytes, count, at);
}
ssize_t pwrite(int file, const void* bytes, size_t count, off_t at) {
    static auto* const real = next<ssize_t(int, const void*, size_t, off_t)>("pwrite");
    return fails() ? -1 : real(file, bytes, count, at);
}
int ftruncate64(int file, off64_t bytes) {
    static auto* const real = next<int(int, off64_t)>("ftruncate64");
    return fails() ? -1 : real(file, bytes);
}
int ftruncate(int file, off_t bytes) {
    static auto* const real = next<int(int, off_t)>("ftruncate");
    return fails() ? -1 : real(file, bytes);
}
int fdatasync(int file) {
    static auto* const real = next<int(int)>("fdatasync");
    return fails() ? -1 : real(file);
}
int fsync(int file) {
    static auto* const real = next<int(int)>("fsync");
    return fails() ? -1 : real(file);
}
int statvfs64(const char* path, struct statvfs64* status) {
    static auto* const real = next<int(const char*, struct statvfs64*)>("statvfs64");
    const int result = real(path, status);
    if (result == 0 && shaker::orders::disk == Disk::full) status->f_bavail = status->f_bfree = 0;
    return result;
}
int statvfs(const char* path, struct statvfs* status) {
    static auto* const real = next<int(const char*, struct statvfs*)>("statvfs");
    const int result = real(path, status);
    if (result == 0 && shaker::orders::disk == Disk::full) status->f_bavail = status->f_bfree = 0;
    return result;
}

}  // extern "C"

#endif

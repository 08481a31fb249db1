// A failing disk for the files of one folder (SHAKER_DISK_FOLDER). SHAKER_DISK_FAULT is "call ending after_s
// error stall_s": from after_s seconds of the program on, `call` on files whose name ends in `ending` ("*":
// all) fails with this errno, or blocks until stall_s seconds are over. `call` is "write", "sync", "any"
// (both, and reserving of space) or "space" (the query of free space of any folder). SHAKER_DISK_ROOM: size
// of the disk, bytes.
#include <sys/statvfs.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <optional>
#include <sstream>
#include <thread>

#include "tests/preload/interposed.hpp"

namespace {

using namespace shaker::interposed;
using Clock = std::chrono::steady_clock;

const Clock::time_point began = Clock::now();

struct Fault {
    std::string call, ending;
    double after_s = 0;
    int error = 0;
    double stall_s = 0;
};

const std::optional<Fault>& fault() {
    static const std::optional<Fault> told = [] {
        const char* text = std::getenv("SHAKER_DISK_FAULT");
        if (text == nullptr) return std::optional<Fault>{};
        Fault f;
        std::istringstream in{text};
        in >> f.call >> f.ending >> f.after_s >> f.error >> f.stall_s;
        if (!in) std::abort();
        return std::optional{f};
    }();
    return told;
}

// Waits as the fault requires. Returns the errno with which this call must fail, or 0.
int trouble(const char* call, const std::string& name) {
    if (!fault()) return 0;
    const Fault& f = *fault();
    if ((f.call != "any" && f.call != call) || (f.ending != "*" && !name.ends_with(f.ending))) return 0;
    const auto since = [&](double s) {
        return began + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>{s});
    };
    if (Clock::now() < since(f.after_s)) return 0;
    std::this_thread::sleep_until(since(f.after_s + f.stall_s));
    return f.error;
}

std::optional<std::int64_t> room() {
    static const std::optional<std::int64_t> bytes = [] {
        const char* text = std::getenv("SHAKER_DISK_ROOM");
        return text == nullptr ? std::nullopt : std::optional<std::int64_t>{std::atoll(text)};
    }();
    return bytes;
}

std::atomic<std::int64_t> taken{0};

std::int64_t length_of(int descriptor) {
    struct stat status {};
    return ::fstat(descriptor, &status) == 0 ? status.st_size : 0;
}

// Accounts for the growth of a file to length `end`. Returns an errno, or 0.
int take(int descriptor, std::int64_t end) {
    const std::int64_t more = end - length_of(descriptor);
    if (!room() || more <= 0) return 0;
    if (taken + more > *room()) return ENOSPC;
    taken += more;
    return 0;
}

template <class Value>
Value failed(int error) {
    errno = error;
    return -1;
}

int told_room(int result, struct statvfs* disk) {
    if (result != 0 || !room()) return result;
    const std::int64_t left = std::max<std::int64_t>(0, *room() - taken);
    disk->f_bavail = disk->f_bfree = static_cast<fsblkcnt_t>(left) / disk->f_frsize;
    return result;
}

}  // namespace

extern "C" {

ssize_t pwrite(int descriptor, const void* data, size_t bytes, off_t at) {
    auto* const next = real<ssize_t(int, const void*, size_t, off_t)>("pwrite");
    const std::string name = meant(descriptor);
    if (name.empty()) return next(descriptor, data, bytes, at);
    if (const int error = trouble("write", name)) return failed<ssize_t>(error);
    if (const int error = take(descriptor, at + static_cast<off_t>(bytes))) return failed<ssize_t>(error);
    return next(descriptor, data, bytes, at);
}

ssize_t write(int descriptor, const void* data, size_t bytes) {
    auto* const next = real<ssize_t(int, const void*, size_t)>("write");
    const std::string name = meant(descriptor);
    if (name.empty()) return next(descriptor, data, bytes);
    if (const int error = trouble("write", name)) return failed<ssize_t>(error);
    if (const int error = take(descriptor, length_of(descriptor) + static_cast<std::int64_t>(bytes)))
        return failed<ssize_t>(error);
    return next(descriptor, data, bytes);
}

int posix_fallocate(int descriptor, off_t at, off_t bytes) {
    const std::string name = meant(descriptor);
    if (!name.empty()) {
        if (const int error = trouble("reserve", name)) return error;
        if (const int error = take(descriptor, at + bytes)) return error;
    }
    return real<int(int, off_t, off_t)>("posix_fallocate")(descriptor, at, bytes);
}

int fdatasync(int descriptor) {
    const std::string name = meant(descriptor);
    if (const int error = name.empty() ? 0 : trouble("sync", name)) return failed<int>(error);
    return real<int(int)>("fdatasync")(descriptor);
}

int fsync(int descriptor) {
    const std::string name = meant(descriptor);
    if (const int error = name.empty() ? 0 : trouble("sync", name)) return failed<int>(error);
    return real<int(int)>("fsync")(descriptor);
}

int statvfs(const char* path, struct statvfs* disk) noexcept {
    if (fault() && fault()->call == "space")
        if (const int error = trouble("space", path)) return failed<int>(error);
    return told_room(real<int(const char*, struct statvfs*)>("statvfs")(path, disk), disk);
}

int fstatvfs(int descriptor, struct statvfs* disk) noexcept {
    return told_room(real<int(int, struct statvfs*)>("fstatvfs")(descriptor, disk), disk);
}

}  // extern "C"

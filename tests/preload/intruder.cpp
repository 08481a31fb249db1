// An attacker inside of whatever opens a data file: at the first one, tries to read SHAKER_INTRUDER_READ and
// to create SHAKER_INTRUDER_WRITE, and prints both answers to standard error: 0 or errno. Calls the kernel
// directly, as code of an attacker does.
#include <fcntl.h>
#include <sys/syscall.h>

#include <atomic>
#include <cstdarg>

#include "tests/preload/interposed.hpp"

namespace {

using namespace shaker::interposed;

int opened(const char* variable, int flags) {
    const long file = ::syscall(SYS_openat, AT_FDCWD, std::getenv(variable), flags, 0600);
    return file < 0 ? errno : 0;
}

void intrude(std::string_view path, int flags) {
    static std::atomic<bool> done{false};
    if (std::getenv("SHAKER_INTRUDER_READ") == nullptr || (flags & O_PATH) != 0) return;
    if (!path.ends_with(".nxs") && !path.ends_with(".part") && !path.ends_with(".mkv")) return;
    if (done.exchange(true)) return;
    const int before = errno;
    const int read = opened("SHAKER_INTRUDER_READ", O_RDONLY);
    const int written = opened("SHAKER_INTRUDER_WRITE", O_WRONLY | O_CREAT);
    std::array<char, 64> text{};
    const int length =
        std::snprintf(text.data(), text.size(), "intruder: read %d, write %d\n", read, written);
    if (::write(STDERR_FILENO, text.data(), static_cast<std::size_t>(length)) < 0) std::abort();
    errno = before;
}

mode_t mode_after(int flags, va_list arguments) {
    return (flags & (O_CREAT | O_TMPFILE)) != 0 ? va_arg(arguments, mode_t) : 0;
}

}  // namespace

extern "C" {

int open(const char* path, int flags, ...) {
    va_list arguments;
    va_start(arguments, flags);
    const mode_t mode = mode_after(flags, arguments);
    va_end(arguments);
    intrude(path, flags);
    return real<int(const char*, int, ...)>("open")(path, flags, mode);
}

int open64(const char* path, int flags, ...) {
    va_list arguments;
    va_start(arguments, flags);
    const mode_t mode = mode_after(flags, arguments);
    va_end(arguments);
    intrude(path, flags);
    return real<int(const char*, int, ...)>("open64")(path, flags, mode);
}
}

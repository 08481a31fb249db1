// A computer in trouble, while the file SHAKER_TROUBLE exists: calls that make or write through files below
// SHAKER_DISK_FOLDER take SHAKER_SLOW_S seconds, or, when that is 0, no thread is granted.
#include <fcntl.h>
#include <pthread.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <thread>

#include "tests/preload/interposed.hpp"

namespace {

using namespace shaker::interposed;

bool troubled() noexcept {
    const char* file = std::getenv("SHAKER_TROUBLE");
    const int before = errno;
    const bool exists = file != nullptr && ::access(file, F_OK) == 0;
    errno = before;
    return exists;
}

double slow_s() noexcept {
    const char* text = std::getenv("SHAKER_SLOW_S");
    return text == nullptr ? 0 : std::atof(text);
}

void wait_for_disk(bool meant) {
    if (meant && slow_s() > 0 && troubled())
        std::this_thread::sleep_for(std::chrono::duration<double>{slow_s()});
}

int opened(const char* name, const char* path, int flags, mode_t mode) {
    if ((flags & O_CREAT) != 0) wait_for_disk(is_meant(absolute(path)));
    return real<int(const char*, int, ...)>(name)(path, flags, mode);
}

}  // namespace

extern "C" {

int open(const char* path, int flags, ...) {
    va_list list;
    va_start(list, flags);
    const mode_t mode = (flags & O_CREAT) != 0 ? va_arg(list, mode_t) : 0;
    va_end(list);
    return opened("open", path, flags, mode);
}

int open64(const char* path, int flags, ...) {
    va_list list;
    va_start(list, flags);
    const mode_t mode = (flags & O_CREAT) != 0 ? va_arg(list, mode_t) : 0;
    va_end(list);
    return opened("open64", path, flags, mode);
}

int fsync(int descriptor) {
    wait_for_disk(!meant(descriptor).empty());
    return real<int(int)>("fsync")(descriptor);
}

int fdatasync(int descriptor) {
    wait_for_disk(!meant(descriptor).empty());
    return real<int(int)>("fdatasync")(descriptor);
}

int mkdir(const char* path, mode_t mode) noexcept {
    wait_for_disk(is_meant(absolute(path)));
    return real<int(const char*, mode_t)>("mkdir")(path, mode);
}

int rename(const char* from, const char* to) noexcept {
    wait_for_disk(is_meant(absolute(to)));
    return real<int(const char*, const char*)>("rename")(from, to);
}

int pthread_create(pthread_t* thread, const pthread_attr_t* attributes, void* (*begin)(void*),
                   void* argument) noexcept {
    if (slow_s() == 0 && troubled()) return EAGAIN;
    return real<int(pthread_t*, const pthread_attr_t*, void* (*)(void*), void*)>("pthread_create")(
        thread, attributes, begin, argument);
}
}

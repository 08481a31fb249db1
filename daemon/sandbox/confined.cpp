#include "daemon/sandbox/confined.hpp"

#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <new>
#include <stdexcept>

#include "daemon/manual/exit_status.hpp"
#include "daemon/sandbox/syscall_filter.hpp"
#include "drivers/errors.hpp"
#include "drivers/recorded/recording_file.hpp"

namespace shaker::sandbox {

namespace {

constexpr double gib = 1U << 30U;

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool limits_memory = false;
#else
constexpr bool limits_memory = true;
#endif

std::uint64_t bytes_of(const std::filesystem::path& file) {
    std::error_code missing;  // reported when the file is opened
    const std::uintmax_t size = std::filesystem::file_size(file, missing);
    return missing ? 0 : size;
}

// A limit that is already lower is kept.
void lower(__rlimit_resource resource, rlim_t soft, rlim_t hard) {
    rlimit now{};
    getrlimit(resource, &now);
    const rlimit wanted{std::min(soft, now.rlim_max), std::min(hard, now.rlim_max)};
    setrlimit(resource, &wanted);
}

void give_up_rights(const Confinement& allowed) {
    std::ofstream{"/proc/self/oom_score_adj"}
        << "1000";  // the kernel ends this process first when memory is short
    lower(RLIMIT_CORE, 0, 0);
    // The soft limit sends SIGXCPU; the hard limit, one second later, kills.
    lower(RLIMIT_CPU, allowed.processor_s, allowed.processor_s + 1);
    if (limits_memory) lower(RLIMIT_AS, allowed.memory_bytes, allowed.memory_bytes);
    setenv("HDF5_PLUGIN_PATH", "", 1);
    prctl(PR_SET_DUMPABLE, 0);
    prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
    if (const std::string refused = filter_syscalls(allowed.writes_files); !refused.empty())
        spdlog::warn(
            "the system cannot confine a file reader ({}); only its memory and processor time are limited",
            refused);
}

[[noreturn]] void be_child(const std::string& file, const Confinement& allowed,
                           const std::function<int()>& work, pid_t parent) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (getppid() != parent) _exit(manual::exit_failure);  // the parent ended before the line above
    const int status = manual::exit_status_of([&] {
        try {
            give_up_rights(allowed);
            return work();
        } catch (const std::bad_alloc&) {
            throw InputError{
                fmt::format("{}: reading needs more than {:.1f} GiB of memory; the file is damaged or "
                            "malicious",
                            file, static_cast<double>(allowed.memory_bytes) / gib)};
        }
    });
    spdlog::default_logger()->flush();
    std::fflush(nullptr);
    _exit(status);  // without atexit handlers and destructors, which belong to the parent
}

double seconds(const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
}

bool is_crash(int signal) {
    constexpr int crashes[] = {SIGSEGV, SIGBUS, SIGABRT, SIGFPE, SIGILL, SIGTRAP, SIGSYS};
    return std::ranges::find(crashes, signal) != std::end(crashes);
}

}  // namespace

Confinement confinement_for(const std::filesystem::path& file) {
    const std::uint64_t bytes = bytes_of(file);
    std::uint64_t pictures = 0;
    std::error_code missing;
    for (const auto& picture : std::filesystem::directory_iterator{recorded::pictures_folder(file), missing})
        pictures += bytes_of(picture.path());
    return {.memory_bytes = (std::uint64_t{4} << 30U) + 20 * bytes,
            .processor_s = 600 + 60 * ((bytes + pictures) >> 30U)};
}

ChildEnd run_confined(const std::string& file, const Confinement& allowed, const std::function<int()>& work) {
    std::fflush(nullptr);  // or the child would write buffered output again
    const pid_t parent = getpid();
    const pid_t child = fork();
    if (child < 0) throw DeviceError{"starting a reader for " + file + ": " + std::strerror(errno)};
    if (child == 0) be_child(file, allowed, work, parent);
    int status = 0;
    rusage used{};
    while (wait4(child, &status, 0, &used) < 0)
        if (errno != EINTR)
            throw DeviceError{"waiting for the reader of " + file + ": " + std::strerror(errno)};
    return {.status = WIFEXITED(status) ? WEXITSTATUS(status) : 0,
            .signal = WIFSIGNALED(status) ? WTERMSIG(status) : 0,
            .processor_s = seconds(used.ru_utime) + seconds(used.ru_stime)};
}

int confined(const std::string& file, const Confinement& allowed, const std::function<int()>& work) {
    const ChildEnd end = run_confined(file, allowed, work);
    if (end.signal == 0) return end.status;
    const std::string signal = fmt::format("signal {}, {}", end.signal, strsignal(end.signal));
    if (end.signal == SIGXCPU ||
        (end.signal == SIGKILL && end.processor_s >= static_cast<double>(allowed.processor_s)))
        throw InputError{
            fmt::format("{}: reading took more than {} s of processor time; the file is damaged or "
                        "malicious",
                        file, allowed.processor_s)};
    if (is_crash(end.signal))
        throw InputError{
            fmt::format("{}: the file crashed its reader ({}); it is damaged or malicious", file, signal)};
    throw std::runtime_error{fmt::format("{}: its reader was killed by another process ({})", file, signal)};
}

}  // namespace shaker::sandbox

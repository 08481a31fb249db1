#include "daemon/sandbox/confined.hpp"

#include <fcntl.h>
#include <linux/capability.h>
#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <climits>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <memory>
#include <new>
#include <stdexcept>

#include "daemon/manual/command.hpp"
#include "daemon/sandbox/relay.hpp"
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

// Of root's privileges, only those stay that open files of other users.
void drop_privileges() {
    __user_cap_header_struct header{_LINUX_CAPABILITY_VERSION_3, 0};
    std::array<__user_cap_data_struct, _LINUX_CAPABILITY_U32S_3> sets{};
    if (syscall(SYS_capget, &header, sets.data()) < 0) return;
    constexpr std::uint32_t files = 1U << CAP_DAC_OVERRIDE | 1U << CAP_DAC_READ_SEARCH;
    for (std::uint32_t kept = files; __user_cap_data_struct & set : sets) {
        set = {set.effective & kept, set.permitted & kept, 0};
        kept = 0;
    }
    syscall(SYS_capset, &header, sets.data());
}

// Cannot be attached to or read by other processes while it exists. Its own children inherit this.
class Undumpable {
public:
    Undumpable() { prctl(PR_SET_DUMPABLE, 0); }
    ~Undumpable() {
        if (before_ == 1) prctl(PR_SET_DUMPABLE, 1);
    }
    Undumpable(const Undumpable&) = delete;
    Undumpable& operator=(const Undumpable&) = delete;

private:
    int before_ = prctl(PR_GET_DUMPABLE);
};

void restrict_further(const Confinement& allowed) {
    const bool writes = !allowed.files.writes.empty();
    const std::string no_landlock = restrict_files(allowed.files);
    const std::string no_filter = filter_syscalls(writes);
    if (allowed.warns && !no_landlock.empty())
        spdlog::warn(
            "the system cannot restrict a file reader to its files ({}): it could read{} every file of its "
            "user. Read files of unknown origin on Linux 5.13 or later with Landlock",
            no_landlock, writes ? " and write" : "");
    if (allowed.warns && !no_filter.empty())
        spdlog::warn("the system cannot restrict the system calls of a file reader ({})", no_filter);
}

void give_up_rights(const Confinement& allowed) {
    prctl(PR_SET_DUMPABLE, 1);  // or the next line would need privileges
    std::ofstream{"/proc/self/oom_score_adj"}
        << "1000";  // the kernel ends this process first when memory is short
    prctl(PR_SET_DUMPABLE, 0);
    lower(RLIMIT_CORE, 0, 0);
    // The soft limit sends SIGXCPU; the hard limit, one second later, kills.
    lower(RLIMIT_CPU, allowed.processor_s, allowed.processor_s + 1);
    if (limits_memory) lower(RLIMIT_AS, allowed.memory_bytes, allowed.memory_bytes);
    setenv("HDF5_PLUGIN_PATH", "", 1);
    prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
    drop_privileges();
    restrict_further(allowed);
}

// Sockets and files of the process that started this one could carry data out.
void close_others(std::vector<int> kept) {
    std::ranges::sort(kept);
    int next = STDERR_FILENO + 1;
    for (const int fd : kept) {
        if (fd < next) continue;
        if (fd > next) close_range(static_cast<unsigned>(next), static_cast<unsigned>(fd) - 1, 0);
        next = fd + 1;
    }
    close_range(static_cast<unsigned>(next), UINT_MAX, 0);
}

[[noreturn]] void be_child(const std::string& file, const Confinement& allowed,
                           const std::function<int()>& work, pid_t parent, Relay& output) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (getppid() != parent) _exit(manual::exit_failure);  // the parent ended before the line above
    const int status = manual::exit_status_of([&] {
        try {
            output.send();
            close_others(allowed.keeps);
            if (allowed.prepare) allowed.prepare();
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

// A pipe must not get the number of a standard descriptor that the caller of this program has closed.
void open_standard_descriptors() {
    int fd = 0;
    while (fd >= 0 && fd <= STDERR_FILENO) fd = ::open("/dev/null", O_RDWR);
    if (fd >= 0) ::close(fd);
}

bool is_crash(int signal) {
    constexpr int crashes[] = {SIGSEGV, SIGBUS, SIGABRT, SIGFPE, SIGILL, SIGTRAP};
    return std::ranges::find(crashes, signal) != std::end(crashes);
}

}  // namespace

Confinement confinement_for(const std::filesystem::path& file) {
    const std::filesystem::path folder = recorded::pictures_folder(file);
    const std::uint64_t bytes = bytes_of(file);
    std::uint64_t pictures = 0;
    std::error_code missing;
    for (const auto& picture : std::filesystem::directory_iterator{folder, missing})
        pictures += bytes_of(picture.path());
    return {.memory_bytes = (std::uint64_t{4} << 30U) + 20 * bytes,
            .processor_s = 600 + 60 * ((bytes + pictures) >> 30U),
            .files = {.reads = {file, folder}}};
}

ChildEnd run_confined(const std::string& file, const Confinement& allowed, const std::function<int()>& work) {
    std::fflush(nullptr);  // or the child would write buffered output again
    open_standard_descriptors();
    const Undumpable hidden;
    Relay output;
    const pid_t parent = getpid();
    const pid_t child = fork();
    if (child < 0) throw DeviceError{"starting a reader for " + file + ": " + std::strerror(errno)};
    if (child == 0) be_child(file, allowed, work, parent, output);
    output.receive();
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
    if (end.signal == SIGSYS)
        throw InputError{fmt::format(
            "{}: its reader made a system call that reading does not need ({}) and was ended; the file is "
            "damaged or malicious",
            file, signal)};
    if (is_crash(end.signal))
        throw InputError{
            fmt::format("{}: the file crashed its reader ({}); it is damaged or malicious", file, signal)};
    throw std::runtime_error{fmt::format("{}: its reader was killed by another process ({})", file, signal)};
}

Answer ask_confined(const std::string& file, const Confinement& allowed,
                    const std::function<std::string()>& work) {
    const std::unique_ptr<std::FILE, int (*)(std::FILE*)> memory{std::tmpfile(), &std::fclose};
    if (!memory) throw DeviceError{"memory for the reader of " + file + ": " + std::strerror(errno)};
    Answer answer;
    Confinement with_answer = allowed;
    with_answer.keeps.push_back(fileno(memory.get()));
    answer.status = confined(file, with_answer, [&] {
        const std::string text = work();
        return std::fwrite(text.data(), 1, text.size(), memory.get()) == text.size() &&
                       std::fflush(memory.get()) == 0
                   ? manual::exit_ok
                   : manual::exit_failure;
    });
    if (answer.status != manual::exit_ok) return answer;
    constexpr std::size_t most = 1U << 20U;
    answer.text.resize(most + 1);
    std::rewind(memory.get());
    answer.text.resize(std::fread(answer.text.data(), 1, answer.text.size(), memory.get()));
    if (answer.text.size() > most) throw InputError{file + ": names too many files"};
    return answer;
}

}  // namespace shaker::sandbox

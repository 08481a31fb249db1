#include "daemon/sandbox/rights.hpp"

#include <fcntl.h>
#include <linux/landlock.h>
#include <sched.h>
#include <seccomp.h>
#include <spdlog/fmt/fmt.h>
#include <sys/ioctl.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <initializer_list>
#include <memory>

#include "drivers/descriptor.hpp"

namespace shaker::sandbox {

namespace {

// Rights that came after the headers of Debian 12; the version of the interface that knows them.
constexpr std::uint64_t fs_refer = 1U << 13U;      // 2
constexpr std::uint64_t fs_truncate = 1U << 14U;   // 3
constexpr std::uint64_t net_bind_connect = 3;      // 4
constexpr std::uint64_t fs_ioctl_dev = 1U << 15U;  // 5
constexpr std::uint64_t scope_all = 3;             // 6: abstract sockets and signals

constexpr std::uint64_t read_file = LANDLOCK_ACCESS_FS_READ_FILE;
constexpr std::uint64_t read_folder = read_file | LANDLOCK_ACCESS_FS_READ_DIR;
constexpr std::uint64_t run_file = read_file | LANDLOCK_ACCESS_FS_EXECUTE;
constexpr std::uint64_t write_file = read_file | LANDLOCK_ACCESS_FS_WRITE_FILE | fs_truncate;
constexpr std::uint64_t write_folder = read_folder | write_file | LANDLOCK_ACCESS_FS_MAKE_REG |
                                       LANDLOCK_ACCESS_FS_MAKE_DIR | LANDLOCK_ACCESS_FS_REMOVE_FILE |
                                       LANDLOCK_ACCESS_FS_REMOVE_DIR;

// Files of the system that libraries open while a file is read (threads of OpenCV, local time), and the
// process's own state.
constexpr std::array system_files{"/usr/lib",
                                  "/usr/local/lib",
                                  "/lib",
                                  "/lib64",
                                  "/etc/ld.so.cache",
                                  "/etc/localtime",
                                  "/usr/share/zoneinfo",
                                  "/sys/devices/system/cpu",
                                  "/proc/self"};

// The kernel's landlock_ruleset_attr of version 6. Older kernels take its beginning.
struct Handled {
    std::uint64_t files, net, scope;
};

// Zero, or errno. Files that cannot be opened are passed over: the child cannot open them either. So are
// links to what may be written: others could change them meanwhile.
int allow(int rules, const std::filesystem::path& path, std::uint64_t for_file, std::uint64_t for_folder,
          std::uint64_t known) {
    const bool writes = (for_file & LANDLOCK_ACCESS_FS_WRITE_FILE) != 0;
    const Descriptor there{::open(path.c_str(), O_PATH | O_CLOEXEC | (writes ? O_NOFOLLOW : 0))};
    struct stat status {};
    if (there < 0 || ::fstat(there, &status) < 0 || S_ISLNK(status.st_mode)) return 0;
    landlock_path_beneath_attr rule{};
    rule.allowed_access = (S_ISDIR(status.st_mode) ? for_folder : for_file) & known;
    if (rule.allowed_access == 0) return 0;
    rule.parent_fd = there;
    if (::syscall(SYS_landlock_add_rule, rules, LANDLOCK_RULE_PATH_BENEATH, &rule, 0) == 0) return 0;
    return errno == EBADFD ? 0 : errno;  // a pipe or a socket, which has no place among the files
}

std::string refused(const char* what, int error) { return fmt::format("{}: {}", what, std::strerror(error)); }

class Filter {
public:
    explicit Filter(std::uint32_t otherwise) : rules_{seccomp_init(otherwise), seccomp_release} {
        if (!rules_) error_ = -EINVAL;  // the system does not know this action
        note(seccomp_attr_set(rules_.get(), SCMP_FLTATR_ACT_BADARCH, SCMP_ACT_KILL_PROCESS));  // x32 too
        note(seccomp_attr_set(rules_.get(), SCMP_FLTATR_API_SYSRAWRC, 1));  // the kernel's own errno
        // A binary tree instead of a list: every call passes through it.
        note(seccomp_attr_set(rules_.get(), SCMP_FLTATR_CTL_OPTIMIZE, 2));
    }
    void allow(std::initializer_list<int> calls) {
        for (const int call : calls) add(SCMP_ACT_ALLOW, call, {});
    }
    void refuse(std::initializer_list<int> calls) {
        for (const int call : calls) add(SCMP_ACT_ERRNO(EACCES), call, {});
    }
    void allow_when(int call, scmp_arg_cmp condition) { add(SCMP_ACT_ALLOW, call, {condition}); }
    void refuse_when(int call, scmp_arg_cmp condition) { add(SCMP_ACT_ERRNO(EACCES), call, {condition}); }
    /// Pretends that the kernel does not know the call: the C library then uses an older one.
    void hide(int call) { add(SCMP_ACT_ERRNO(ENOSYS), call, {}); }
    /// Zero, or the first error as a negative errno.
    int load() {
        if (error_ == 0) note(seccomp_load(rules_.get()));
        return error_;
    }

private:
    void add(std::uint32_t action, int call, std::initializer_list<scmp_arg_cmp> conditions) {
        note(seccomp_rule_add_array(rules_.get(), action, call, static_cast<unsigned>(conditions.size()),
                                    conditions.begin()));
    }
    void note(int status) {
        if (status < 0 && error_ == 0) error_ = status;
    }

    std::unique_ptr<void, decltype(&seccomp_release)> rules_;
    int error_ = 0;
};

/// The kernel reads 32 bits of these arguments, so the filter ignores the upper bits.
scmp_arg_cmp is(unsigned argument, std::uint64_t value, std::uint64_t mask = UINT32_MAX) {
    return {argument, SCMP_CMP_MASKED_EQ, mask, value};
}

void allow_reading(Filter& f) {
    f.allow({SCMP_SYS(read), SCMP_SYS(pread64), SCMP_SYS(readv), SCMP_SYS(preadv), SCMP_SYS(lseek),
             SCMP_SYS(close), SCMP_SYS(write), SCMP_SYS(writev)});
    f.allow({SCMP_SYS(stat), SCMP_SYS(fstat), SCMP_SYS(lstat), SCMP_SYS(newfstatat), SCMP_SYS(statx),
             SCMP_SYS(statfs), SCMP_SYS(fstatfs), SCMP_SYS(access), SCMP_SYS(faccessat), SCMP_SYS(faccessat2),
             SCMP_SYS(readlink), SCMP_SYS(readlinkat), SCMP_SYS(getdents64), SCMP_SYS(getcwd)});
    f.allow({SCMP_SYS(flock), SCMP_SYS(fadvise64), SCMP_SYS(dup), SCMP_SYS(dup2), SCMP_SYS(dup3),
             SCMP_SYS(pipe), SCMP_SYS(pipe2), SCMP_SYS(poll)});
    for (const int what : {F_GETFD, F_SETFD, F_GETFL, F_SETFL, F_DUPFD, F_DUPFD_CLOEXEC, F_GETLK, F_SETLK,
                           F_OFD_GETLK, F_OFD_SETLK})
        f.allow_when(SCMP_SYS(fcntl), is(1, static_cast<std::uint64_t>(what)));
    f.allow_when(SCMP_SYS(ioctl), is(1, TCGETS));  // used by isatty()
}

void allow_memory_and_threads(Filter& f) {
    f.allow({SCMP_SYS(mmap), SCMP_SYS(mprotect), SCMP_SYS(munmap), SCMP_SYS(mremap), SCMP_SYS(brk),
             SCMP_SYS(madvise), SCMP_SYS(futex), SCMP_SYS(membarrier), SCMP_SYS(set_robust_list),
             SCMP_SYS(rseq), SCMP_SYS(set_tid_address), SCMP_SYS(sched_yield), SCMP_SYS(sched_getaffinity),
             SCMP_SYS(getcpu), SCMP_SYS(exit), SCMP_SYS(exit_group)});
    f.allow_when(SCMP_SYS(clone), is(0, CLONE_THREAD, CLONE_THREAD));
    f.hide(SCMP_SYS(clone3));  // its flags are in memory, which a filter cannot read; glibc then uses clone
    for (const int name : {PR_SET_NAME, PR_GET_NAME, PR_GET_DUMPABLE, PR_GET_NO_NEW_PRIVS})
        f.allow_when(SCMP_SYS(prctl), is(0, static_cast<std::uint64_t>(name)));
}

void allow_own_state(Filter& f) {
    f.allow({SCMP_SYS(getpid), SCMP_SYS(getppid), SCMP_SYS(gettid), SCMP_SYS(getuid), SCMP_SYS(geteuid),
             SCMP_SYS(getgid), SCMP_SYS(getegid), SCMP_SYS(getrandom), SCMP_SYS(getrusage), SCMP_SYS(times),
             SCMP_SYS(sysinfo), SCMP_SYS(uname), SCMP_SYS(getrlimit)});
    f.allow({SCMP_SYS(clock_gettime), SCMP_SYS(clock_getres), SCMP_SYS(gettimeofday), SCMP_SYS(time),
             SCMP_SYS(nanosleep), SCMP_SYS(clock_nanosleep), SCMP_SYS(alarm), SCMP_SYS(pause)});
    f.allow({SCMP_SYS(rt_sigaction), SCMP_SYS(rt_sigprocmask), SCMP_SYS(rt_sigreturn), SCMP_SYS(sigaltstack),
             SCMP_SYS(restart_syscall)});
    f.allow_when(SCMP_SYS(prlimit64), {2, SCMP_CMP_EQ, 0, 0});  // reads a limit
    const auto self = static_cast<std::uint64_t>(getpid());
    for (const int signal : {SCMP_SYS(kill), SCMP_SYS(tgkill)}) f.allow_when(signal, is(0, self));
}

constexpr unsigned make_unnamed = unsigned{O_TMPFILE} & ~unsigned{O_DIRECTORY};

// A way of opening that is not allowed answers EACCES instead of killing, because libraries try it.
void allow_opening(Filter& f, bool for_writing) {
    for (const auto& [call, flags] : {std::pair{SCMP_SYS(open), 1U}, {SCMP_SYS(openat), 2U}}) {
        const unsigned changes =
            for_writing ? unsigned{O_TRUNC} : unsigned{O_CREAT} | unsigned{O_TRUNC} | make_unnamed;
        f.allow_when(call, is(flags, O_RDONLY, O_ACCMODE | changes));
        f.refuse_when(call, is(flags, O_ACCMODE, O_ACCMODE));
        for (const unsigned access : {unsigned{O_WRONLY}, unsigned{O_RDWR}}) {
            if (for_writing)
                f.allow_when(call, is(flags, access, O_ACCMODE));
            else
                f.refuse_when(call, is(flags, access, O_ACCMODE));
        }
        // Linux before 6.2 empties a file that is opened so without asking Landlock.
        f.refuse_when(call, is(flags, O_TRUNC, O_ACCMODE | O_TRUNC));
        if (for_writing) continue;
        for (const unsigned change : {unsigned{O_CREAT}, make_unnamed})
            f.refuse_when(call, is(flags, change, O_ACCMODE | change));
    }
}

void allow_writing(Filter& f) {
    f.allow({SCMP_SYS(creat),     SCMP_SYS(memfd_create),    SCMP_SYS(pwrite64),  SCMP_SYS(ftruncate),
             SCMP_SYS(fallocate), SCMP_SYS(fsync),           SCMP_SYS(fdatasync), SCMP_SYS(sync_file_range),
             SCMP_SYS(sendfile),  SCMP_SYS(copy_file_range), SCMP_SYS(pwritev),   SCMP_SYS(rename),
             SCMP_SYS(renameat),  SCMP_SYS(renameat2),       SCMP_SYS(unlink),    SCMP_SYS(link),
             SCMP_SYS(unlinkat),  SCMP_SYS(rmdir),           SCMP_SYS(mkdir),     SCMP_SYS(mkdirat)});
    f.allow_when(SCMP_SYS(fchmod), is(1, 0, S_ISUID | S_ISGID));  // of a copied file
}

std::string loaded(Filter& filter) {
    const int status = filter.load();
    return status == 0 ? "" : std::string{"seccomp: "} + std::strerror(-status);
}

}  // namespace

std::string restrict_files(const FileRights& allowed) {
    const long version = ::syscall(SYS_landlock_create_ruleset, nullptr, 0, LANDLOCK_CREATE_RULESET_VERSION);
    if (version < 1) return refused("Landlock", errno);
    Handled handled{.files = fs_refer - 1, .net = 0, .scope = 0};  // all of version 1
    if (version >= 2) handled.files |= fs_refer;
    if (version >= 3) handled.files |= fs_truncate;
    if (version >= 4) handled.net = net_bind_connect;
    if (version >= 5) handled.files |= fs_ioctl_dev;
    if (version >= 6) handled.scope = scope_all;
    const std::size_t size = version < 4   ? sizeof handled.files
                             : version < 6 ? 2 * sizeof handled.net
                                           : sizeof handled;
    const Descriptor rules{static_cast<int>(::syscall(SYS_landlock_create_ruleset, &handled, size, 0))};
    if (rules < 0) return refused("Landlock", errno);
    int error = 0;
    const auto add = [&](const std::filesystem::path& path, std::uint64_t for_file,
                         std::uint64_t for_folder) {
        if (error == 0) error = allow(rules, path, for_file, for_folder, handled.files);
    };
    for (const char* path : system_files) add(path, read_file, read_folder);
    for (const auto& path : allowed.lists) add(path, 0, LANDLOCK_ACCESS_FS_READ_DIR);
    for (const auto& path : allowed.reads) add(path, read_file, read_folder);
    for (const auto& path : allowed.runs) add(path, run_file, read_folder | run_file);
    for (const auto& path : allowed.writes) add(path, write_file, write_folder);
    if (error == 0 && ::syscall(SYS_landlock_restrict_self, int{rules}, 0) < 0) error = errno;
    return error == 0 ? "" : refused("Landlock", error);
}

std::string filter_syscalls(bool writes_files) {
    Filter filter{SCMP_ACT_KILL_PROCESS};
    allow_reading(filter);
    allow_memory_and_threads(filter);
    allow_own_state(filter);
    allow_opening(filter, writes_files);
    if (writes_files) allow_writing(filter);
    return loaded(filter);
}

std::string deny_network() {
    Filter filter{SCMP_ACT_ALLOW};
    filter.refuse({SCMP_SYS(socket), SCMP_SYS(socketpair), SCMP_SYS(connect), SCMP_SYS(bind),
                   SCMP_SYS(listen), SCMP_SYS(io_uring_setup), SCMP_SYS(ptrace), SCMP_SYS(process_vm_readv),
                   SCMP_SYS(process_vm_writev), SCMP_SYS(pidfd_getfd), SCMP_SYS(unshare), SCMP_SYS(setns),
                   SCMP_SYS(mount), SCMP_SYS(bpf), SCMP_SYS(keyctl), SCMP_SYS(add_key), SCMP_SYS(request_key),
                   SCMP_SYS(userfaultfd), SCMP_SYS(perf_event_open)});
    return loaded(filter);
}

}  // namespace shaker::sandbox

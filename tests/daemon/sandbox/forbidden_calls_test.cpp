// System calls that a confined child cannot make.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <linux/keyctl.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/mount.h>
#include <sys/msg.h>
#include <sys/prctl.h>
#include <sys/ptrace.h>
#include <sys/resource.h>
#include <sys/sem.h>
#include <sys/shm.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <set>
#include <string>
#include <vector>

#include "tests/support/sandbox/attempts.hpp"

namespace shaker::sandbox {
namespace {

using test::Attempt;
using test::died;
using test::opened;
using test::outcome_of;
using test::succeeded;
using test::word;

/// System calls that change files by name, or reach beyond them.
std::vector<Attempt> on_names(const std::string& secret, const std::string& fresh) {
    const std::array<std::uint64_t, 3> how{O_RDWR, 0, 0};
    return {
        {"openat2()", [=] { return syscall(SYS_openat2, AT_FDCWD, secret.c_str(), how.data(), sizeof how); },
         died},
        {"symlink()", [=] { return symlink("/", fresh.c_str()); }, died},
        {"mknod()", [=] { return mknod(fresh.c_str(), S_IFIFO, 0); }, died},
        {"truncate()", [=] { return truncate(secret.c_str(), 0); }, died},
        {"chmod()", [=] { return chmod(secret.c_str(), 0777); }, died},
        {"fchmodat2()", [=] { return syscall(452, AT_FDCWD, secret.c_str(), 0777, 0); }, died},
        {"chown()", [=] { return chown(secret.c_str(), 1, 1); }, died},
        {"utimensat()", [=] { return utimensat(AT_FDCWD, secret.c_str(), nullptr, 0); }, died},
        {"setxattr()", [=] { return syscall(SYS_setxattr, secret.c_str(), "user.a", "b", 1, 0); }, died},
        {"setxattrat()", [=] { return syscall(463, AT_FDCWD, secret.c_str(), 0, "user.a", how.data(), 16); },
         died},
        {"name_to_handle_at()",
         [=] { return syscall(SYS_name_to_handle_at, AT_FDCWD, secret.c_str(), nullptr, nullptr, 0); }, died},
        {"open_by_handle_at()", [=] { return syscall(SYS_open_by_handle_at, AT_FDCWD, nullptr, O_RDONLY); },
         died},
        {"chdir()", [] { return chdir("/"); }, died},
        {"chroot()", [] { return chroot("/"); }, died},
        {"mount()", [] { return mount("none", "/mnt", "tmpfs", 0, nullptr); }, died},
        {"umount2()", [] { return umount2("/mnt", 0); }, died},
        {"open_tree()", [] { return syscall(SYS_open_tree, AT_FDCWD, "/", 1); }, died},
        {"fsopen()", [] { return syscall(SYS_fsopen, "tmpfs", 0); }, died},
        {"pivot_root()", [] { return syscall(SYS_pivot_root, "/", "/"); }, died},
        {"inotify_init()", [] { return syscall(SYS_inotify_init); }, died},
        {"fanotify_init()", [] { return syscall(SYS_fanotify_init, 0, 0); }, died},
    };
}

std::vector<Attempt> on_processes(int program) {
    const pid_t parent = getpid();
    static std::array<char, 8> memory{};
    static const iovec here{memory.data(), memory.size()}, there{memory.data(), memory.size()};
    return {
        {"ptrace()", [=] { return ptrace(PTRACE_ATTACH, parent, nullptr, nullptr); }, died},
        {"process_vm_readv()", [=] { return process_vm_readv(parent, &here, 1, &there, 1, 0); }, died},
        {"process_vm_writev()", [=] { return process_vm_writev(parent, &here, 1, &there, 1, 0); }, died},
        {"process_madvise()", [=] { return syscall(SYS_process_madvise, parent, &here, 1, MADV_COLD, 0); },
         died},
        {"kill() of the parent", [=] { return kill(parent, 0); }, died},
        {"kill() of all", [] { return kill(-1, 0); }, died},
        {"tgkill() of the parent", [=] { return syscall(SYS_tgkill, parent, parent, 0); }, died},
        {"tkill()", [=] { return syscall(SYS_tkill, parent, 0); }, died},
        {"rt_sigqueueinfo()", [=] { return syscall(SYS_rt_sigqueueinfo, parent, 0, nullptr); }, died},
        {"pidfd_open()", [=] { return syscall(SYS_pidfd_open, parent, 0); }, died},
        {"pidfd_getfd()", [=] { return syscall(SYS_pidfd_getfd, 0, 0, 0); }, died},
        {"pidfd_send_signal()", [] { return syscall(SYS_pidfd_send_signal, 0, 0, nullptr, 0); }, died},
        {"kcmp()", [=] { return syscall(SYS_kcmp, parent, getpid(), 0, 0, 0); }, died},
        {"signals from a file", [=] { return fcntl(0, F_SETOWN, parent); }, died},
        {"limits of the parent",
         [=] {
             const rlimit none{0, 0};
             return prlimit(parent, RLIMIT_CORE, &none, nullptr);
         },
         died},
        {"its own limits",
         [] {
             const rlimit none{RLIM_INFINITY, RLIM_INFINITY};
             return setrlimit(RLIMIT_CPU, &none);
         },
         died},
        {"setpriority()", [] { return setpriority(PRIO_PROCESS, 0, -5); }, died},
        {"sched_setscheduler()",
         [] {
             const sched_param best{50};
             return sched_setscheduler(0, SCHED_FIFO, &best);
         },
         died},
        {"outliving the parent", [] { return prctl(PR_SET_PDEATHSIG, 0); }, died},
        {"outliving it by higher bits", [] { return syscall(SYS_prctl, PR_SET_PDEATHSIG | (1UL << 32U), 0); },
         died},
        {"becoming dumpable", [] { return prctl(PR_SET_DUMPABLE, 1); }, died},
        {"fork()", [] { return fork(); }, died},
        {"the system call fork", [] { return syscall(SYS_fork); }, died},
        {"the system call vfork", [] { return syscall(SYS_vfork) == 0 ? (_exit(succeeded), 0) : 0; }, died},
        {"clone3()", [] { return syscall(SYS_clone3, nullptr, 0); }, ENOSYS},
        {"execve()", [] { return execl("/bin/true", "true", nullptr); }, died},
        {"execve() of an open file",
         [=] {
             char name[] = "true";
             char* const words[] = {name, nullptr};
             return fexecve(program, words, environ);
         },
         died},
        {"a program from memory",
         [] {
             const int made = memfd_create("program", 0);
             char name[] = "p";
             char* const words[] = {name, nullptr};
             return write(made, "#!/bin/true\n", 12) < 0 ? -1 : fexecve(made, words, environ);
         },
         died},
    };
}

std::vector<Attempt> on_the_network(int inherited) {
    static const sockaddr nobody{};
    std::vector<Attempt> all{
        {"socketpair()",
         [] {
             std::array<int, 2> pair{};
             return socketpair(AF_UNIX, SOCK_STREAM, 0, pair.data());
         },
         died},
        {"connect()", [=] { return connect(inherited, &nobody, sizeof nobody); }, died},
        {"bind()", [=] { return bind(inherited, &nobody, sizeof nobody); }, died},
        {"sendto()", [=] { return sendto(inherited, "x", 1, 0, &nobody, sizeof nobody); }, died},
        {"sendmsg()",
         [=] {
             const msghdr message{};
             return sendmsg(inherited, &message, 0);
         },
         died},
    };
    for (const int family : {AF_UNIX, AF_INET, AF_INET6, AF_NETLINK, AF_PACKET, AF_ALG, AF_VSOCK})
        all.push_back({"socket()", [=] { return socket(family, SOCK_DGRAM, 0); }, died});
    return all;
}

#ifdef __x86_64__
/// getpid as programs of 32 bits call it.
long call_of_32_bits() {
    (void)std::signal(SIGSEGV, SIG_DFL);  // a sanitiser would answer it with a report
    long answer = 20;
    asm volatile("int $0x80" : "+a"(answer)::"memory", "r8", "r9", "r10", "r11");
    return answer;
}

/// The end of a confined child by that call: by its filter, or by SIGSEGV before any filter on a kernel
/// without calls of 32 bits.
int end_by_32_bits() {
    const pid_t unconfined = fork();
    if (unconfined == 0) _exit(call_of_32_bits() == getpid() ? 0 : 1);
    int status = 0;
    waitpid(unconfined, &status, 0);
    const bool missing = WIFSIGNALED(status) && WTERMSIG(status) == SIGSEGV;
    return missing ? 128 + SIGSEGV : died;
}
#endif

std::vector<Attempt> on_the_kernel() {
    return {
        {"unshare()", [] { return unshare(CLONE_NEWUSER); }, died},
        {"setns()", [] { return setns(0, 0); }, died},
        {"keyctl()", [] { return syscall(SYS_keyctl, KEYCTL_GET_KEYRING_ID, -3, 1); }, died},
        {"add_key()", [] { return syscall(SYS_add_key, "user", "a", "b", 1, -3); }, died},
        {"request_key()", [] { return syscall(SYS_request_key, "user", "a", nullptr, -3); }, died},
        {"bpf()", [] { return syscall(SYS_bpf, 0, nullptr, 0); }, died},
        {"perf_event_open()", [] { return syscall(SYS_perf_event_open, nullptr, 0, -1, -1, 0); }, died},
        {"userfaultfd()", [] { return syscall(SYS_userfaultfd, 0); }, died},
        {"io_uring_setup()", [] { return syscall(SYS_io_uring_setup, 1, nullptr); }, died},
        {"io_uring_enter()", [] { return syscall(SYS_io_uring_enter, 0, 0, 0, 0, nullptr, 0); }, died},
        {"io_setup()", [] { return syscall(SYS_io_setup, 1, nullptr); }, died},
        {"msgget()", [] { return msgget(IPC_PRIVATE, IPC_CREAT | 0600); }, died},
        {"msgsnd()",
         [] {
             const std::array<long, 2> message{1, 0};
             return msgsnd(0, message.data(), 0, IPC_NOWAIT);
         },
         died},
        {"msgctl()", [] { return msgctl(0, IPC_RMID, nullptr); }, died},
        {"shmget()", [] { return shmget(IPC_PRIVATE, 1, IPC_CREAT | 0600); }, died},
        {"shmat()", [] { return shmat(0, nullptr, 0) == nullptr ? 0L : -1L; }, died},
        {"shmctl()", [] { return shmctl(0, IPC_RMID, nullptr); }, died},
        {"semget()", [] { return semget(IPC_PRIVATE, 1, IPC_CREAT | 0600); }, died},
        {"semctl()", [] { return semctl(0, 0, IPC_RMID); }, died},
        {"mq_open()", [] { return syscall(SYS_mq_open, "a", O_RDONLY, 0, nullptr); }, died},
        {"typing into a terminal", [] { return ioctl(0, TIOCSTI, "x"); }, died},
        {"typing by higher bits", [] { return syscall(SYS_ioctl, 0, TIOCSTI | (1UL << 32U), "x"); }, died},
        {"personality()", [] { return syscall(SYS_personality, 0xffffffff); }, died},
        {"setuid()", [] { return syscall(SYS_setuid, 0); }, died},
        {"capset()", [] { return syscall(SYS_capset, nullptr, nullptr); }, died},
        {"seccomp()", [] { return syscall(SYS_seccomp, 0, 0, nullptr); }, died},
        {"a call of x32", [] { return syscall(0x40000000 | SYS_getpid); }, died},
#ifdef __x86_64__
        {"a call of 32 bits", call_of_32_bits, end_by_32_bits()},
#endif
    };
}

using ForbiddenCallsTest = test::AttemptsTest;

TEST_F(ForbiddenCallsTest, FilesAreNotChangedByName) { expect_refused(on_names(secret_, home_ / "fresh")); }

TEST_F(ForbiddenCallsTest, ProcessesStayOutOfReach) {
    const int program = opened("/bin/true", O_RDONLY);
    expect_refused(on_processes(program));
    ::close(program);
}

TEST_F(ForbiddenCallsTest, ThereIsNoNetwork) {
    const int inherited = ::socket(AF_INET, SOCK_DGRAM, 0);
    expect_refused(on_the_network(inherited));
    ::close(inherited);
}

TEST_F(ForbiddenCallsTest, KernelInterfacesStayClosed) { expect_refused(on_the_kernel()); }

/// Numbers of the system calls of this architecture that both kinds may make.
const std::set<long> listed{SYS_read,
                            SYS_pread64,
                            SYS_readv,
                            SYS_preadv,
                            SYS_lseek,
                            SYS_close,
                            SYS_write,
                            SYS_writev,
                            SYS_stat,
                            SYS_fstat,
                            SYS_lstat,
                            SYS_newfstatat,
                            SYS_statx,
                            SYS_statfs,
                            SYS_fstatfs,
                            SYS_access,
                            SYS_faccessat,
                            SYS_faccessat2,
                            SYS_readlink,
                            SYS_readlinkat,
                            SYS_getdents64,
                            SYS_getcwd,
                            SYS_flock,
                            SYS_fadvise64,
                            SYS_dup,
                            SYS_dup2,
                            SYS_dup3,
                            SYS_pipe,
                            SYS_pipe2,
                            SYS_poll,
                            SYS_open,
                            SYS_openat,
                            SYS_mmap,
                            SYS_mprotect,
                            SYS_munmap,
                            SYS_mremap,
                            SYS_brk,
                            SYS_madvise,
                            SYS_futex,
                            SYS_membarrier,
                            SYS_set_robust_list,
                            SYS_rseq,
                            SYS_set_tid_address,
                            SYS_sched_yield,
                            SYS_sched_getaffinity,
                            SYS_getcpu,
                            SYS_exit,
                            SYS_exit_group,
                            SYS_clone,
                            SYS_clone3,
                            SYS_getpid,
                            SYS_getppid,
                            SYS_gettid,
                            SYS_getuid,
                            SYS_geteuid,
                            SYS_getgid,
                            SYS_getegid,
                            SYS_getrandom,
                            SYS_getrusage,
                            SYS_times,
                            SYS_sysinfo,
                            SYS_uname,
                            SYS_getrlimit,
                            SYS_clock_gettime,
                            SYS_clock_getres,
                            SYS_gettimeofday,
                            SYS_time,
                            SYS_nanosleep,
                            SYS_clock_nanosleep,
                            SYS_alarm,
                            SYS_pause,
                            SYS_rt_sigaction,
                            SYS_rt_sigprocmask,
                            SYS_rt_sigreturn,
                            SYS_sigaltstack,
                            SYS_restart_syscall};
const std::set<long> listed_for_writers{
    SYS_creat,   SYS_memfd_create, SYS_pwrite64,        SYS_ftruncate, SYS_fallocate,
    SYS_fsync,   SYS_fdatasync,    SYS_sync_file_range, SYS_sendfile,  SYS_copy_file_range,
    SYS_pwritev, SYS_rename,       SYS_renameat,        SYS_renameat2, SYS_unlink,
    SYS_link,    SYS_unlinkat,     SYS_rmdir,           SYS_mkdir,     SYS_mkdirat};

/// uretprobe and uprobe: newer kernels ask no filter, and answer these calls only at their own trampoline.
const std::set<long> asked_by_no_filter{335, 336};

TEST_F(ForbiddenCallsTest, EveryOtherCallEndsTheChild) {
    constexpr long step = SHAKER_SANITIZED ? 8 : 1;  // a process with a sanitiser starts slowly
    int killed = 0;
    for (const bool writer : {false, true})
        for (long number = 0; number <= 512; number += step) {
            if (asked_by_no_filter.contains(number) || listed.contains(number) ||
                (writer && listed_for_writers.contains(number)))
                continue;
            EXPECT_EQ(
                word(outcome_of(rights(writer), [=] { return syscall(number, -1, -1, -1, -1, -1, -1); })),
                "killed")
                << (writer ? "writer: " : "reader: ") << number;
            ++killed;
        }
    EXPECT_GT(killed, 800 / step);
}

}  // namespace
}  // namespace shaker::sandbox

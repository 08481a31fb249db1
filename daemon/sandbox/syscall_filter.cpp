#include "daemon/sandbox/syscall_filter.hpp"

#include <fcntl.h>
#include <sched.h>
#include <seccomp.h>
#include <sys/ioctl.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstring>
#include <initializer_list>
#include <memory>

namespace shaker::sandbox {

namespace {

class Filter {
public:
    Filter() : rules_{seccomp_init(SCMP_ACT_ALLOW), seccomp_release} {
        if (!rules_) error_ = -ENOMEM;
        note(seccomp_attr_set(rules_.get(), SCMP_FLTATR_API_SYSRAWRC, 1));  // the kernel's own errno
        // A binary tree instead of a list: every call passes through it.
        note(seccomp_attr_set(rules_.get(), SCMP_FLTATR_CTL_OPTIMIZE, 2));
    }
    void refuse(std::initializer_list<int> calls) {
        for (const int call : calls) add(EPERM, call, {});
    }
    void refuse_when(int call, scmp_arg_cmp condition) { add(EPERM, call, {condition}); }
    /// Pretends that the kernel does not know the call: the C library then uses an older one that can be
    /// filtered.
    void hide(int call) { add(ENOSYS, call, {}); }
    /// Zero, or the first error as a negative errno.
    int load() {
        if (error_ == 0) note(seccomp_load(rules_.get()));
        return error_;
    }

private:
    void add(int answer, int call, std::initializer_list<scmp_arg_cmp> conditions) {
        note(seccomp_rule_add_array(rules_.get(), SCMP_ACT_ERRNO(static_cast<std::uint32_t>(answer)), call,
                                    static_cast<unsigned>(conditions.size()), conditions.begin()));
    }
    void note(int status) {
        if (status < 0 && error_ == 0) error_ = status;
    }

    std::unique_ptr<void, decltype(&seccomp_release)> rules_;
    int error_ = 0;
};

scmp_arg_cmp differs(unsigned argument, std::uint64_t value) { return {argument, SCMP_CMP_NE, value, 0}; }

/// The kernel reads 32 bits of these arguments, so the filter ignores the upper bits.
scmp_arg_cmp has(unsigned argument, std::uint64_t mask, std::uint64_t value) {
    return {argument, SCMP_CMP_MASKED_EQ, mask, value};
}

void refuse_network(Filter& f) {
    f.refuse({SCMP_SYS(socket), SCMP_SYS(socketpair), SCMP_SYS(connect), SCMP_SYS(bind), SCMP_SYS(listen),
              SCMP_SYS(accept), SCMP_SYS(accept4), SCMP_SYS(sendto), SCMP_SYS(sendmsg), SCMP_SYS(sendmmsg),
              SCMP_SYS(recvfrom), SCMP_SYS(recvmsg), SCMP_SYS(recvmmsg)});
}

void refuse_other_processes(Filter& f) {
    f.refuse({SCMP_SYS(execve),
              SCMP_SYS(execveat),
              SCMP_SYS(fork),
              SCMP_SYS(vfork),
              SCMP_SYS(ptrace),
              SCMP_SYS(process_vm_readv),
              SCMP_SYS(process_vm_writev),
              SCMP_SYS(process_madvise),
              SCMP_SYS(kcmp),
              SCMP_SYS(pidfd_open),
              SCMP_SYS(pidfd_getfd),
              SCMP_SYS(pidfd_send_signal),
              SCMP_SYS(tkill),
              SCMP_SYS(rt_sigqueueinfo),
              SCMP_SYS(setpriority),
              SCMP_SYS(sched_setscheduler),
              SCMP_SYS(sched_setparam),
              SCMP_SYS(sched_setattr),
              SCMP_SYS(shmget),
              SCMP_SYS(shmat),
              SCMP_SYS(semget),
              SCMP_SYS(msgget),
              SCMP_SYS(mq_open)});
    f.refuse_when(SCMP_SYS(clone), has(0, CLONE_THREAD, 0));
    f.hide(SCMP_SYS(clone3));
    const auto self = static_cast<std::uint64_t>(getpid());
    f.refuse_when(SCMP_SYS(kill), differs(0, self));
    f.refuse_when(SCMP_SYS(tgkill), differs(0, self));
    f.refuse_when(SCMP_SYS(rt_tgsigqueueinfo), differs(0, self));
    for (const int owner : {F_SETOWN, F_SETOWN_EX})  // a file could then send signals to another process
        f.refuse_when(SCMP_SYS(fcntl), has(1, UINT32_MAX, static_cast<std::uint64_t>(owner)));
    for (const int option : {PR_SET_PDEATHSIG, PR_SET_DUMPABLE})
        f.refuse_when(SCMP_SYS(prctl), has(0, UINT32_MAX, static_cast<std::uint64_t>(option)));
    f.refuse({SCMP_SYS(setrlimit)});
    f.refuse_when(SCMP_SYS(prlimit64), differs(2, 0));
    f.refuse_when(SCMP_SYS(ioctl), differs(1, TCGETS));  // used by isatty()
}

void refuse_system(Filter& f) {
    f.refuse({SCMP_SYS(mount), SCMP_SYS(umount2), SCMP_SYS(pivot_root), SCMP_SYS(chroot),
              SCMP_SYS(mount_setattr), SCMP_SYS(move_mount), SCMP_SYS(open_tree), SCMP_SYS(fsopen),
              SCMP_SYS(fsconfig), SCMP_SYS(fsmount), SCMP_SYS(fspick), SCMP_SYS(unshare), SCMP_SYS(setns),
              SCMP_SYS(name_to_handle_at), SCMP_SYS(open_by_handle_at), SCMP_SYS(quotactl), SCMP_SYS(acct),
              SCMP_SYS(swapon), SCMP_SYS(swapoff)});
    f.refuse({SCMP_SYS(bpf), SCMP_SYS(perf_event_open), SCMP_SYS(userfaultfd), SCMP_SYS(io_uring_setup),
              SCMP_SYS(io_uring_enter), SCMP_SYS(io_uring_register), SCMP_SYS(io_setup), SCMP_SYS(io_submit),
              SCMP_SYS(fanotify_init), SCMP_SYS(keyctl), SCMP_SYS(add_key), SCMP_SYS(request_key)});
    f.refuse({SCMP_SYS(init_module),   SCMP_SYS(finit_module),    SCMP_SYS(delete_module),
              SCMP_SYS(kexec_load),    SCMP_SYS(kexec_file_load), SCMP_SYS(reboot),
              SCMP_SYS(sethostname),   SCMP_SYS(setdomainname),   SCMP_SYS(settimeofday),
              SCMP_SYS(clock_settime), SCMP_SYS(adjtimex),        SCMP_SYS(clock_adjtime),
              SCMP_SYS(iopl),          SCMP_SYS(ioperm),          SCMP_SYS(modify_ldt),
              SCMP_SYS(personality),   SCMP_SYS(syslog),          SCMP_SYS(setuid),
              SCMP_SYS(setgid),        SCMP_SYS(setreuid),        SCMP_SYS(setregid),
              SCMP_SYS(setresuid),     SCMP_SYS(setresgid),       SCMP_SYS(setgroups),
              SCMP_SYS(setfsuid),      SCMP_SYS(setfsgid),        SCMP_SYS(capset)});
}

void refuse_writing(Filter& f) {
    f.refuse({SCMP_SYS(creat),       SCMP_SYS(truncate),     SCMP_SYS(ftruncate),   SCMP_SYS(fallocate),
              SCMP_SYS(rename),      SCMP_SYS(renameat),     SCMP_SYS(renameat2),   SCMP_SYS(unlink),
              SCMP_SYS(unlinkat),    SCMP_SYS(rmdir),        SCMP_SYS(mkdir),       SCMP_SYS(mkdirat),
              SCMP_SYS(link),        SCMP_SYS(linkat),       SCMP_SYS(symlink),     SCMP_SYS(symlinkat),
              SCMP_SYS(mknod),       SCMP_SYS(mknodat),      SCMP_SYS(chmod),       SCMP_SYS(fchmod),
              SCMP_SYS(fchmodat),    SCMP_SYS(chown),        SCMP_SYS(lchown),      SCMP_SYS(fchown),
              SCMP_SYS(fchownat),    SCMP_SYS(utime),        SCMP_SYS(utimes),      SCMP_SYS(futimesat),
              SCMP_SYS(utimensat),   SCMP_SYS(setxattr),     SCMP_SYS(lsetxattr),   SCMP_SYS(fsetxattr),
              SCMP_SYS(removexattr), SCMP_SYS(lremovexattr), SCMP_SYS(fremovexattr)});
    f.hide(SCMP_SYS(openat2));  // its flags are in memory, which a filter cannot read
    for (const auto& [call, flags] : {std::pair{SCMP_SYS(open), 1U}, {SCMP_SYS(openat), 2U}}) {
        for (const unsigned access : {unsigned{O_WRONLY}, unsigned{O_RDWR}, unsigned{O_ACCMODE}})
            f.refuse_when(call, has(flags, O_ACCMODE, access));
        for (const unsigned change : {unsigned{O_CREAT}, unsigned{O_TRUNC}})
            f.refuse_when(call, has(flags, change, change));
    }
}

}  // namespace

std::string filter_syscalls(bool writes_files) {
    Filter filter;
    refuse_network(filter);
    refuse_other_processes(filter);
    refuse_system(filter);
    if (!writes_files) refuse_writing(filter);
    const int status = filter.load();
    return status == 0 ? "" : std::string{"seccomp: "} + std::strerror(-status);
}

}  // namespace shaker::sandbox

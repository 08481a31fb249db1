// Rights of a confined child, and the report of its end.
#include "daemon/sandbox/confined.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <poll.h>
#include <spawn.h>
#include <sys/ioctl.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstddef>
#include <fstream>
#include <memory>
#include <thread>
#include <vector>

#include "daemon/manual/exit_status.hpp"
#include "drivers/errors.hpp"
#include "tests/support/program.hpp"

namespace shaker::sandbox {
namespace {

constexpr Confinement ample{.memory_bytes = std::uint64_t{8} << 30U, .processor_s = 60};

struct End {
    int status = -1;
    std::string said;     // by the child
    std::string refused;  // text of the InputError
};

End confine(const std::function<int()>& work, const Confinement& allowed = ample) {
    End end;
    testing::internal::CaptureStdout();
    testing::internal::CaptureStderr();
    try {
        end.status = confined("some.nxs", allowed, work);
    } catch (const InputError& error) {
        end.refused = error.what();
    }
    end.said = testing::internal::GetCapturedStdout() + testing::internal::GetCapturedStderr();
    return end;
}

/// Result of a system call in a confined child: 0 or errno.
template <class Call>
int answer(Call call, const Confinement& allowed = ample) {
    return confine([&] { return call() < 0 ? errno : 0; }, allowed).status;
}

void expect_in(const std::string& text, std::initializer_list<const char*> parts) {
    for (const char* part : parts)
        EXPECT_NE(text.find(part), std::string::npos) << "\"" << part << "\" is not in: " << text;
}

TEST(ConfinedTest, PassesOnExitStatusAndOutput) {
    EXPECT_EQ(confine([] { return 0; }).status, 0);
    const End end = confine([] {
        std::printf("printed\n");
        return 4;
    });
    EXPECT_EQ(end.status, 4);
    EXPECT_EQ(end.said, "printed\n");
}

TEST(ConfinedTest, PrintsEarlierOutputOnce) {
    testing::internal::CaptureStdout();
    std::printf("before ");
    run_confined("some.nxs", ample, [] { return std::printf("inside "); });
    std::printf("after");
    EXPECT_EQ(testing::internal::GetCapturedStdout(), "before inside after");
}

TEST(ConfinedTest, ExceptionsKeepClassAndText) {
    const auto thrown = [](auto error) { return confine([error]() -> int { throw error; }); };
    const End input = thrown(InputError{"file: 7 is not 8"}), device = thrown(DeviceError{"disk: gone"}),
              tripped = thrown(TripError{"too fast"}), other = thrown(std::runtime_error{"odd"});
    EXPECT_EQ(input.status, manual::exit_input);
    expect_in(input.said, {"shakerd: file: 7 is not 8"});
    EXPECT_EQ(device.status, manual::exit_device);
    expect_in(device.said, {"shakerd: disk: gone"});
    EXPECT_EQ(tripped.status, manual::exit_tripped);
    expect_in(tripped.said, {"the drive was stopped: too fast"});
    EXPECT_EQ(other.status, manual::exit_failure);
    expect_in(other.said, {"shakerd: odd"});
}

TEST(ConfinedTest, ReportsCrashAsFaultOfTheFile) {
    if (SHAKER_SANITIZED) GTEST_SKIP() << "the sanitiser answers a crash with a report and exit status 1";
    const End crash = confine([] {
        const volatile int* nowhere = nullptr;
        return *nowhere;
    });
    expect_in(crash.refused, {"some.nxs", "crashed its reader (signal 11, Segmentation fault)", "damaged"});
    expect_in(confine([]() -> int { std::abort(); }).refused, {"some.nxs", "signal 6, Aborted"});
}

TEST(ConfinedTest, KillFromOutsideIsNotTheFilesFault) {
    try {
        confined("some.nxs", ample, [] { return kill(getpid(), SIGTERM); });
        FAIL() << "nothing was thrown";
    } catch (const std::runtime_error& error) {
        EXPECT_EQ(dynamic_cast<const InputError*>(&error), nullptr);
        expect_in(error.what(), {"some.nxs", "killed by another process", "signal 15"});
    }
}

TEST(ConfinedTest, ProcessorTimeEndsEndlessWork) {
    const auto spin = [] {
        volatile bool go_on = true;
        while (go_on) {
        }
        return 0;
    };
    const auto began = std::chrono::steady_clock::now();
    expect_in(confine(spin, {.memory_bytes = ample.memory_bytes, .processor_s = 1}).refused,
              {"some.nxs", "more than 1 s of processor time", "damaged"});
    EXPECT_LT(std::chrono::steady_clock::now() - began, std::chrono::seconds{30});
    // Ignoring the first signal does not help.
    const auto stubborn = [&] {
        (void)std::signal(SIGXCPU, SIG_IGN);
        return spin();
    };
    expect_in(confine(stubborn, {.memory_bytes = ample.memory_bytes, .processor_s = 1}).refused,
              {"more than 1 s of processor time"});
}

TEST(ConfinedTest, RefusesEndlessMemory) {
    if (SHAKER_SANITIZED) GTEST_SKIP() << "a sanitiser reserves terabytes: memory is not limited under it";
    const End end = confine(
        [] {
            std::vector<std::unique_ptr<char[]>> taken;
            for (;;) taken.push_back(std::make_unique<char[]>(64U << 20U));
            return 0;
        },
        {.memory_bytes = std::uint64_t{2} << 30U, .processor_s = 60});
    EXPECT_EQ(end.status, manual::exit_input);
    expect_in(end.said, {"some.nxs", "more than 2.0 GiB of memory", "damaged"});
}

TEST(ConfinedTest, ThereIsNoNetwork) {
    for (const int family : {AF_UNIX, AF_INET, AF_INET6, AF_NETLINK})
        EXPECT_EQ(answer([&] { return socket(family, SOCK_DGRAM, 0); }), EPERM) << family;
    std::array<int, 2> pair{};
    EXPECT_EQ(answer([&] { return socketpair(AF_UNIX, SOCK_STREAM, 0, pair.data()); }), EPERM);
    // A socket that is open already cannot connect.
    const int open = socket(AF_INET, SOCK_DGRAM, 0);
    ASSERT_GE(open, 0);
    const sockaddr nobody{};
    EXPECT_EQ(answer([&] { return connect(open, &nobody, sizeof nobody); }), EPERM);
    EXPECT_EQ(answer([&] { return bind(open, &nobody, sizeof nobody); }), EPERM);
    close(open);
}

TEST(ConfinedTest, NoOtherProgramOrProcessIsStarted) {
    EXPECT_EQ(answer([] { return execl("/bin/true", "true", nullptr); }), EPERM);
    EXPECT_EQ(answer([] { return fork(); }), EPERM);
    EXPECT_EQ(confine([] {
                  char name[] = "/bin/true";
                  char* const words[] = {name, nullptr};
                  pid_t child = 0;
                  return posix_spawn(&child, name, nullptr, nullptr, words, environ);
              }).status,
              EPERM);
    EXPECT_EQ(confine([] {
                  int seen = 0;
                  std::thread{[&] { seen = 7; }}.join();  // threads are allowed
                  return seen;
              }).status,
              7);
}

TEST(ConfinedTest, OtherProcessesAreOutOfReach) {
    const pid_t parent = getpid();
    EXPECT_EQ(answer([&] { return kill(parent, 0); }), EPERM);
    EXPECT_EQ(answer([&] { return kill(-1, 0); }), EPERM);
    EXPECT_EQ(answer([&] { return syscall(SYS_tgkill, parent, parent, 0); }), EPERM);
    EXPECT_EQ(answer([&] { return syscall(SYS_tkill, parent, 0); }), EPERM);
    EXPECT_EQ(answer([&] { return syscall(SYS_ptrace, 16, parent, 0, 0); }), EPERM);
    EXPECT_EQ(answer([&] { return syscall(SYS_pidfd_open, parent, 0); }), EPERM);
    EXPECT_EQ(answer([&] { return fcntl(0, F_SETOWN, parent); }), EPERM);
    EXPECT_EQ(answer([] { return kill(getpid(), 0); }), 0);
}

TEST(ConfinedTest, RefusesOtherKernelInterfaces) {
    EXPECT_EQ(answer([] { return syscall(SYS_mount, "none", "/", "tmpfs", 0, nullptr); }), EPERM);
    EXPECT_EQ(answer([] { return syscall(SYS_unshare, CLONE_NEWUSER); }), EPERM);
    EXPECT_EQ(answer([] { return syscall(SYS_bpf, 0, nullptr, 0); }), EPERM);
    EXPECT_EQ(answer([] { return syscall(SYS_io_uring_setup, 1, nullptr); }), EPERM);
    EXPECT_EQ(answer([] { return syscall(SYS_ioctl, 0, TIOCSTI, "x"); }), EPERM);
    // The kernel uses 32 bits of this argument; higher bits must not bypass the filter.
    EXPECT_EQ(answer([] { return syscall(SYS_ioctl, 0, TIOCSTI | (1UL << 32U), "x"); }), EPERM);
    EXPECT_EQ(answer([] { return syscall(SYS_prctl, PR_SET_PDEATHSIG | (1UL << 32U), 0); }), EPERM);
}

TEST(ConfinedTest, FilesAreReadAndNotWritten) {
    const auto folder = test::fresh_folder();
    const std::string file = folder / "there", other = folder / "new";
    std::ofstream{file} << "content";
    const auto opened = [](const std::string& name, int flags) {
        return answer([&] { return open(name.c_str(), flags, 0644); });
    };
    EXPECT_EQ(opened(file, O_RDONLY), 0);
    for (const int flags : {O_WRONLY, O_RDWR, O_RDONLY | O_TRUNC, O_WRONLY | O_APPEND})
        EXPECT_EQ(opened(file, flags), EPERM) << flags;
    for (const int flags : {O_WRONLY | O_CREAT, O_RDWR | O_CREAT | O_EXCL, O_RDONLY | O_CREAT})
        EXPECT_EQ(opened(other, flags), EPERM) << flags;
    EXPECT_EQ(opened(folder, O_RDWR | O_TMPFILE), EPERM);
    EXPECT_EQ(answer([&] { return unlink(file.c_str()); }), EPERM);
    EXPECT_EQ(answer([&] { return rename(file.c_str(), other.c_str()); }), EPERM);
    EXPECT_EQ(answer([&] { return link(file.c_str(), other.c_str()); }), EPERM);
    EXPECT_EQ(answer([&] { return symlink(file.c_str(), other.c_str()); }), EPERM);
    EXPECT_EQ(answer([&] { return mkdir(other.c_str(), 0755); }), EPERM);
    EXPECT_EQ(answer([&] { return truncate(file.c_str(), 0); }), EPERM);
    EXPECT_EQ(answer([&] { return chmod(file.c_str(), 0777); }), EPERM);
    const std::array<std::uint64_t, 3> how{O_RDWR, 0, 0};
    EXPECT_EQ(answer([&] { return syscall(SYS_openat2, AT_FDCWD, file.c_str(), how.data(), sizeof how); }),
              ENOSYS);
    std::string left;
    std::ifstream{file} >> left;
    EXPECT_EQ(left, "content");
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator{folder}, {}), 1);
}

TEST(ConfinedTest, FileWritersMayDoNothingElse) {
    const auto folder = test::fresh_folder();
    const std::string file = folder / "new";
    Confinement writer = ample;
    writer.writes_files = true;
    EXPECT_EQ(answer([&] { return open(file.c_str(), O_WRONLY | O_CREAT, 0644); }, writer), 0);
    EXPECT_TRUE(std::filesystem::exists(file));
    EXPECT_EQ(answer([&] { return unlink(file.c_str()); }, writer), 0);
    EXPECT_FALSE(std::filesystem::exists(file));
    EXPECT_EQ(answer([] { return socket(AF_UNIX, SOCK_STREAM, 0); }, writer), EPERM);
    EXPECT_EQ(answer([] { return execl("/bin/true", "true", nullptr); }, writer), EPERM);
}

TEST(ConfinedTest, ItsLimitsAreSetAndCannotBeRaised) {
    const auto state = [] {
        rlimit core{}, memory{}, processor{};
        getrlimit(RLIMIT_CORE, &core);
        getrlimit(RLIMIT_AS, &memory);
        getrlimit(RLIMIT_CPU, &processor);
        std::printf("core %lu memory %lu processor %lu new rights %d dumpable %d plug-ins \"%s\"",
                    core.rlim_max, memory.rlim_max >> 30U, processor.rlim_cur,
                    prctl(PR_GET_NO_NEW_PRIVS, 0, 0, 0, 0), prctl(PR_GET_DUMPABLE),
                    getenv("HDF5_PLUGIN_PATH"));
        return 0;
    };
    const std::string limits = SHAKER_SANITIZED ? "processor 60" : "memory 8 processor 60";
    expect_in(confine(state).said, {"core 0", limits.c_str(), "new rights 1 dumpable 0 plug-ins \"\""});
    const rlimit none{RLIM_INFINITY, RLIM_INFINITY};
    EXPECT_EQ(answer([&] { return setrlimit(RLIMIT_CPU, &none); }), EPERM);
    EXPECT_EQ(answer([&] { return syscall(SYS_setrlimit, RLIMIT_AS, &none); }), EPERM);
    EXPECT_EQ(confine([] {
                  int score = 0;
                  std::ifstream{"/proc/self/oom_score_adj"} >> score;
                  return score == 1000 ? 0 : 1;
              }).status,
              0);
}

TEST(ConfinedTest, LimitsGrowWithTheFile) {
    const auto folder = test::fresh_folder();
    std::ofstream{folder / "file"} << "x";
    std::filesystem::resize_file(folder / "file", std::uintmax_t{3} << 30U);  // sparse
    const Confinement small = confinement_for(folder / "none"), large = confinement_for(folder / "file");
    EXPECT_EQ(small.memory_bytes, std::uint64_t{4} << 30U);
    EXPECT_EQ(small.processor_s, 600U);
    EXPECT_EQ(large.memory_bytes, std::uint64_t{64} << 30U);
    EXPECT_EQ(large.processor_s, 780U);
    EXPECT_FALSE(large.writes_files);
}

TEST(ConfinedTest, ItEndsWithItsParent) {
    std::array<int, 2> pipe{};
    ASSERT_EQ(::pipe(pipe.data()), 0);
    const pid_t parent = fork();
    if (parent == 0) {
        run_confined("some.nxs", ample, [&] {
            if (write(pipe[1], "x", 1) != 1) return 1;
            for (;;) pause();
        });
        _exit(0);
    }
    close(pipe[1]);
    char said = 0;
    ASSERT_EQ(read(pipe[0], &said, 1), 1);
    kill(parent, SIGTERM);
    int status = 0;
    waitpid(parent, &status, 0);
    EXPECT_TRUE(WIFSIGNALED(status));
    pollfd end{.fd = pipe[0], .events = POLLIN, .revents = 0};
    ASSERT_EQ(poll(&end, 1, 20'000), 1) << "the child goes on without its parent";
    EXPECT_EQ(read(pipe[0], &said, 1), 0);
    close(pipe[0]);
}

/// Makes this process behave as on a system without filters of system calls.
void refuse_filters() {
    const auto jump = [](unsigned value, unsigned char to) {
        return sock_filter{BPF_JMP | BPF_JEQ | BPF_K, to, 0, value};
    };
    const auto load = [](unsigned at) { return sock_filter{BPF_LD | BPF_W | BPF_ABS, 0, 0, at}; };
    std::array<sock_filter, 7> program{load(offsetof(seccomp_data, nr)),
                                       jump(SYS_seccomp, 4),
                                       {BPF_JMP | BPF_JEQ | BPF_K, 0, 2, SYS_prctl},
                                       load(offsetof(seccomp_data, args)),
                                       jump(PR_SET_SECCOMP, 1),
                                       {BPF_RET | BPF_K, 0, 0, SECCOMP_RET_ALLOW},
                                       {BPF_RET | BPF_K, 0, 0, SECCOMP_RET_ERRNO | EINVAL}};
    const sock_fprog filter{static_cast<unsigned short>(program.size()), program.data()};
    prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
    ASSERT_EQ(prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &filter), 0);
}

TEST(ConfinedTest, WarnsWithoutFiltersAndKeepsLimits) {
    testing::internal::CaptureStdout();
    testing::internal::CaptureStderr();
    const pid_t child = fork();
    if (child == 0) {
        refuse_filters();
        const int status = confined("some.nxs", ample, [] {
            rlimit core{};
            getrlimit(RLIMIT_CORE, &core);
            return core.rlim_max == 0 && socket(AF_UNIX, SOCK_STREAM, 0) >= 0 ? 9 : 1;
        });
        _exit(status);
    }
    int status = 0;
    waitpid(child, &status, 0);
    const std::string said = testing::internal::GetCapturedStdout() + testing::internal::GetCapturedStderr();
    EXPECT_EQ(WEXITSTATUS(status), 9) << said;
    expect_in(said, {"cannot confine a file reader (seccomp: Invalid argument)"});
    EXPECT_EQ(said.find("confined (", said.find("confined (") + 1), std::string::npos) << "told once";
}

}  // namespace
}  // namespace shaker::sandbox

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

#include "daemon/manual/command.hpp"
#include "drivers/errors.hpp"
#include "tests/support/missing_calls.hpp"
#include "tests/support/program.hpp"

namespace shaker::sandbox {
namespace {

const Confinement ample{.memory_bytes = std::uint64_t{8} << 30U, .processor_s = 60};

Confinement keeping(int descriptor) {
    Confinement allowed = ample;
    allowed.keeps = {descriptor};
    return allowed;
}

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
            while (taken.size() < 64) taken.push_back(std::make_unique_for_overwrite<char[]>(64U << 20U));
            return 0;  // it has 4 GiB
        },
        {.memory_bytes = std::uint64_t{2} << 30U, .processor_s = 60});
    EXPECT_EQ(end.status, manual::exit_input);
    expect_in(end.said, {"some.nxs", "more than 2.0 GiB of memory", "damaged"});
}

TEST(ConfinedTest, ThreadsAreAllowed) {
    EXPECT_EQ(confine([] {
                  int seen = 0;
                  std::thread{[&] { seen = 7; }}.join();
                  return seen;
              }).status,
              7);
}

TEST(ConfinedTest, ForbiddenCallIsReported) {
    expect_in(
        confine([] { return socket(AF_UNIX, SOCK_STREAM, 0); }).refused,
        {"some.nxs", "system call that reading does not need (signal 31, Bad system call)", "malicious"});
}

TEST(ConfinedTest, OutputIsMadePrintable) {
    const End end = confine([] {
        std::printf(
            "a\x1b[2J\xc2\x9b"
            "b\tm/s\xc2\xb2\n\xff");
        std::fprintf(stderr, "\x1b]0;you\x07\n");
        return write(STDIN_FILENO, "\x1b[2J", 4) < 0 ? 0 : 1;  // a terminal can be written through its input
    });
    EXPECT_EQ(end.status, 0);
    EXPECT_EQ(end.said, "a\\x1b[2J\\u009bb\tm/s\xc2\xb2\n\\xff\\x1b]0;you\\x07\n");
}

TEST(ConfinedTest, CharacterCutBetweenWritesStaysWhole) {
    EXPECT_EQ(confine([] {
                  const bool written = write(STDOUT_FILENO, "\xc2", 1) == 1;
                  std::this_thread::sleep_for(std::chrono::milliseconds{50});
                  return written && write(STDOUT_FILENO, "\x9b", 1) == 1 ? 0 : 1;
              }).said,
              "\\u009b");
}

TEST(ConfinedTest, OutputThatNobodyReadsIsDropped) {
    std::array<int, 2> pipe{};
    ASSERT_EQ(::pipe(pipe.data()), 0);
    close(pipe[0]);
    const pid_t child = fork();
    if (child == 0) {
        dup2(pipe[1], STDOUT_FILENO);
        const auto talk = [] {
            for (int i = 0; i < 100'000; ++i) std::printf("a line that is lost\n");
            return 5;
        };
        _exit(confined("some.nxs", ample, talk));
    }
    close(pipe[1]);
    int status = 0;
    waitpid(child, &status, 0);
    EXPECT_TRUE(WIFEXITED(status));
    EXPECT_EQ(WEXITSTATUS(status), 5);
}

TEST(ConfinedTest, ParentIsUndumpableWhileItReads) {
    ASSERT_EQ(prctl(PR_GET_DUMPABLE), 1);
    EXPECT_EQ(confine([] { return prctl(PR_GET_DUMPABLE) == 0 ? 0 : 1; }).status, 0);
    std::array<int, 2> pipe{};
    ASSERT_EQ(::pipe(pipe.data()), 0);
    const pid_t parent = fork();
    if (parent == 0) {
        if (getuid() == 0 && setuid(65534) != 0) _exit(1);  // root owns its processes in any case
        prctl(PR_SET_DUMPABLE, 1);
        _exit(confined("some.nxs", keeping(pipe[1]), [&] {
            if (write(pipe[1], "x", 1) != 1) return 1;
            for (;;) pause();
        }));
    }
    char said = 0;
    ASSERT_EQ(read(pipe[0], &said, 1), 1);
    struct stat memory {};
    EXPECT_EQ(stat(("/proc/" + std::to_string(parent) + "/mem").c_str(), &memory), 0);
    EXPECT_EQ(memory.st_uid, 0U);  // an undumpable process is root's
    EXPECT_EQ(prctl(PR_GET_DUMPABLE), 1);
    kill(parent, SIGTERM);
    waitpid(parent, nullptr, 0);
    for (const int end : pipe) close(end);
}

TEST(ConfinedTest, KeepsOnlyPrivilegesToOpenFiles) {
    if (getuid() != 0) GTEST_SKIP() << "only root has privileges";
    const End end = confine([] {
        std::ifstream status{"/proc/self/status"};
        for (std::string line; std::getline(status, line);)
            if (line.starts_with("CapEff") || line.starts_with("CapPrm")) std::printf("%s\n", line.c_str());
        return 0;
    });
    EXPECT_EQ(end.said, "CapPrm:\t0000000000000006\nCapEff:\t0000000000000006\n");
}

TEST(ConfinedTest, PreparesWithAllRights) {
    Confinement allowed = ample;
    int socket_before = -1;
    allowed.prepare = [&] { socket_before = socket(AF_UNIX, SOCK_STREAM, 0); };
    EXPECT_EQ(confine([&] { return socket_before >= 0 ? 0 : 1; }, allowed).status, 0);
}

TEST(ConfinedTest, InheritedDescriptorsAreClosed) {
    std::array<int, 2> pipe{};
    ASSERT_EQ(::pipe(pipe.data()), 0);
    const auto tell = [&] { return write(pipe[1], "x", 1) < 0 ? errno : 0; };
    EXPECT_EQ(confine(tell).status, EBADF);
    EXPECT_EQ(confine(tell, keeping(pipe[1])).status, 0);
    for (const int end : pipe) close(end);
}

TEST(ConfinedTest, StandardDescriptorsMayBeClosed) {
    const pid_t child = fork();
    if (child == 0) {
        for (const int fd : {0, 1, 2}) close(fd);
        _exit(run_confined("some.nxs", ample, [] {
                  std::printf("lost");
                  return open("/usr/lib/os-release", O_RDONLY) > 2 ? 5 : 1;
              }).status);
    }
    int status = 0;
    waitpid(child, &status, 0);
    EXPECT_EQ(WEXITSTATUS(status), 5);
}

TEST(ConfinedTest, AnswersWithText) {
    const Answer answer = ask_confined("some.nxs", ample, [] { return std::string{"a\0b", 3}; });
    EXPECT_EQ(answer.status, 0);
    EXPECT_EQ(answer.text, std::string("a\0b", 3));
    EXPECT_THROW(ask_confined("some.nxs", ample, [] { return std::string(2U << 20U, 'x'); }), InputError);
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
    EXPECT_NE(confine([&] { return setrlimit(RLIMIT_CPU, &none); }).refused, "");
    EXPECT_NE(confine([&] { return static_cast<int>(syscall(SYS_setrlimit, RLIMIT_AS, &none)); }).refused,
              "");
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
    EXPECT_TRUE(large.files.writes.empty());
    EXPECT_EQ(large.files.reads, (std::vector{folder / "file", folder / "file.frames"}));
}

TEST(ConfinedTest, ItEndsWithItsParent) {
    std::array<int, 2> pipe{};
    ASSERT_EQ(::pipe(pipe.data()), 0);
    const pid_t parent = fork();
    if (parent == 0) {
        run_confined("some.nxs", keeping(pipe[1]), [&] {
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
    expect_in(said, {"cannot restrict the system calls of a file reader (seccomp: Invalid argument)"});
}

TEST(ConfinedTest, WarnsOnceWithoutLandlock) {
    test::without_landlock([] {
        Confinement second = ample;
        second.warns = false;
        const auto nothing = [] { return 0; };
        const std::string said = confine(nothing).said + confine(nothing, second).said;
        const char* warning =
            "cannot restrict a file reader to its files (Landlock: Operation not supported)";
        EXPECT_NE(said.find(warning), std::string::npos) << said;
        EXPECT_EQ(said.find(warning), said.rfind(warning)) << said;
        EXPECT_NE(confine([] { return socket(AF_UNIX, SOCK_STREAM, 0); }).refused, "") << "seccomp is on";
    });
}

}  // namespace
}  // namespace shaker::sandbox

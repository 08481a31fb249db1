#include "daemon/sandbox/outside_program.hpp"

#include <spdlog/spdlog.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <climits>
#include <csignal>
#include <cstdio>
#include <cstring>

#include "daemon/manual/command.hpp"
#include "daemon/sandbox/relay.hpp"
#include "drivers/errors.hpp"

namespace shaker::sandbox {

namespace {

constexpr int not_started = 127;

std::vector<char*> pointers(const std::vector<std::string>& texts) {
    std::vector<char*> list;
    for (const std::string& text : texts) list.push_back(const_cast<char*>(text.c_str()));
    list.push_back(nullptr);
    return list;
}

[[noreturn]] void be_program(const OutsideProgram& program, pid_t parent, Relay& output) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (getppid() != parent) _exit(manual::exit_failure);  // the parent ended before the line above
    output.send();
    close_range(STDERR_FILENO + 1, UINT_MAX, 0);
    const rlimit no_core{0, 0}, time{program.processor_s, program.processor_s + 1};
    setrlimit(RLIMIT_CORE, &no_core);
    setrlimit(RLIMIT_CPU, &time);
    prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
    FileRights files = program.files;
    files.runs.insert(files.runs.end(), {"/usr/bin", "/usr/lib", "/lib", "/lib64"});
    files.reads.insert(files.reads.end(), {"/usr/bin", "/usr/share", "/etc/fonts", "/etc/python3",
                                           "/etc/matplotlibrc", "/dev/urandom", "/proc/meminfo"});
    files.writes.emplace_back("/dev/null");
    for (const std::string& missing : {restrict_files(files), deny_network()})
        if (!missing.empty())
            spdlog::warn("the system cannot restrict {} ({})", program.words.front(), missing);
    const std::vector<char*> words = pointers(program.words), settings = pointers(program.settings);
    execve(words.front(), words.data(), settings.data());
    std::fprintf(stderr, "%s: %s\n", words.front(), std::strerror(errno));
    _exit(not_started);
}

}  // namespace

int run_outside(const OutsideProgram& program) {
    std::fflush(nullptr);
    Relay output;
    const pid_t parent = getpid();
    const pid_t child = fork();
    if (child < 0) throw DeviceError{"starting " + program.words.front() + ": " + std::strerror(errno)};
    if (child == 0) be_program(program, parent, output);
    output.receive();
    int status = 0;
    while (waitpid(child, &status, 0) < 0)
        if (errno != EINTR)
            throw DeviceError{"waiting for " + program.words.front() + ": " + std::strerror(errno)};
    return WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
}

}  // namespace shaker::sandbox

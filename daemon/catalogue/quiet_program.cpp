#include "daemon/catalogue/quiet_program.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sched.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <exception>
#include <thread>
#include <utility>

#include "drivers/descriptor.hpp"
#include "drivers/errors.hpp"

namespace shaker::catalogue {

namespace {

constexpr int turn_ms = 100;

[[noreturn]] void fail(const std::string& what, int error) {
    throw DeviceError{"starting " + what + ": " + std::strerror(error)};
}

/// One stream of the program's output.
class Output {
public:
    explicit Output(const std::string& what) {
        std::array<int, 2> ends{};
        if (::pipe2(ends.data(), O_CLOEXEC) < 0) fail(what, errno);
        from_ = Descriptor{ends[0]};
        to_ = Descriptor{ends[1]};
    }
    [[nodiscard]] int to() const noexcept { return to_; }
    [[nodiscard]] pollfd wanted() const noexcept { return {.fd = from_, .events = POLLIN, .revents = 0}; }
    [[nodiscard]] bool open() const noexcept { return from_ >= 0; }
    void begin() noexcept { const Descriptor ended = std::move(to_); }
    void read(std::string& to, std::size_t most) {
        std::array<char, 65536> bytes;
        const ssize_t n = ::read(from_, bytes.data(), bytes.size());
        if (n < 0 && errno == EINTR) return;
        if (n <= 0) {
            const Descriptor ended = std::move(from_);
            return;
        }
        to.append(bytes.data(), std::min(static_cast<std::size_t>(n), most - std::min(most, to.size())));
    }

private:
    Descriptor from_, to_;
};

/// Attributes and descriptors of the new process.
class Start {
public:
    Start(const Output& out, const Output& err) {
        posix_spawnattr_init(&attributes_);
        posix_spawn_file_actions_init(&files_);
        sigset_t no_signals, all_signals;
        sigemptyset(&no_signals);
        sigfillset(&all_signals);
        posix_spawnattr_setsigmask(&attributes_, &no_signals);
        posix_spawnattr_setsigdefault(&attributes_, &all_signals);
        posix_spawnattr_setflags(&attributes_,
                                 POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP);
        posix_spawn_file_actions_addopen(&files_, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
        posix_spawn_file_actions_adddup2(&files_, out.to(), STDOUT_FILENO);
        posix_spawn_file_actions_adddup2(&files_, err.to(), STDERR_FILENO);
        posix_spawn_file_actions_addclosefrom_np(&files_, STDERR_FILENO + 1);
    }
    Start(const Start&) = delete;
    Start& operator=(const Start&) = delete;
    ~Start() {
        posix_spawn_file_actions_destroy(&files_);
        posix_spawnattr_destroy(&attributes_);
    }
    [[nodiscard]] pid_t spawn(const std::vector<std::string>& words) const {
        std::vector<char*> pointers;
        for (const std::string& word : words) pointers.push_back(const_cast<char*>(word.c_str()));
        pointers.push_back(nullptr);
        pid_t child = 0;
        if (const int error =
                posix_spawn(&child, pointers.front(), &files_, &attributes_, pointers.data(), environ);
            error != 0)
            fail(words.front(), error);
        return child;
    }

private:
    posix_spawnattr_t attributes_{};
    posix_spawn_file_actions_t files_{};
};

// A process inherits the priority of the thread that starts it. That thread ends here, because an idle one
// may not become ordinary again.
pid_t spawn_idle(const Start& start, const std::vector<std::string>& words) {
    pid_t child = 0;
    std::exception_ptr failure;
    std::thread{[&] {
        try {
            const sched_param none{};
            if (sched_setscheduler(0, SCHED_IDLE, &none) < 0)
                fail(words.front() + " at idle priority", errno);
            child = start.spawn(words);
        } catch (...) {
            failure = std::current_exception();
        }
    }}.join();
    if (failure) std::rethrow_exception(failure);
    return child;
}

/// The program with the processes that it started; killed and waited for at the end of this object.
class Child {
public:
    explicit Child(pid_t process) : process_{process} {}
    Child(const Child&) = delete;
    Child& operator=(const Child&) = delete;
    ~Child() {
        if (process_ > 0) {
            kill();
            static_cast<void>(wait());
        }
    }
    void kill() const noexcept { ::kill(-process_, SIGKILL); }
    int wait() {
        int status = 0;
        while (waitpid(process_, &status, 0) < 0 && errno == EINTR) {
        }
        process_ = -1;
        return WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
    }

private:
    pid_t process_;
};

}  // namespace

std::optional<QuietEnd> run_quietly(const QuietProgram& program, const std::function<bool()>& go_on) {
    Output out{program.words.front()}, err{program.words.front()};
    Child child{spawn_idle(Start{out, err}, program.words)};
    out.begin();
    err.begin();
    const auto end = std::chrono::steady_clock::now() + program.longest;
    QuietEnd ended;
    while (out.open() || err.open()) {
        if (!go_on()) return std::nullopt;
        if (!ended.late && std::chrono::steady_clock::now() >= end) {
            ended.late = true;
            child.kill();
        }
        std::array wanted{out.wanted(), err.wanted()};
        if (::poll(wanted.data(), wanted.size(), turn_ms) <= 0) continue;
        if (wanted[0].revents != 0) out.read(ended.out, program.most_bytes);
        if (wanted[1].revents != 0) err.read(ended.err, program.most_bytes);
    }
    ended.status = child.wait();
    return ended;
}

}  // namespace shaker::catalogue

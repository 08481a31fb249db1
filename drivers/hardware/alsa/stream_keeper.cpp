#include "drivers/hardware/alsa/stream_keeper.hpp"

#include <fcntl.h>
#include <spawn.h>
#include <spdlog/fmt/fmt.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <string>

#include "drivers/errors.hpp"

namespace shaker::alsa {

namespace {

// Attributes of the new process: its descriptors, its own session, signals ignored, so that a signal from the
// terminal or the service manager that ends this process does not end the keeper too.
class Arrangement {
public:
    Arrangement() {
        ::posix_spawn_file_actions_init(&files);
        ::posix_spawnattr_init(&attributes);
        sigset_t all{};
        ::sigfillset(&all);
        ::posix_spawnattr_setsigmask(&attributes, &all);
        ::posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSID | POSIX_SPAWN_SETSIGMASK);
    }
    Arrangement(const Arrangement&) = delete;
    Arrangement& operator=(const Arrangement&) = delete;
    ~Arrangement() {
        ::posix_spawnattr_destroy(&attributes);
        ::posix_spawn_file_actions_destroy(&files);
    }
    posix_spawn_file_actions_t files{};
    posix_spawnattr_t attributes{};
};

}  // namespace

StreamKeeper::StreamKeeper(int descriptor, Seconds lasts) {
    std::array<int, 2> ends{-1, -1};
    int error = ::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) == 0 ? 0 : errno;
    if (error == 0) {
        Arrangement a;
        constexpr int kept = 3;
        // Duplicated above all target descriptors, so that none is overwritten before it is used.
        const int stream = ::fcntl(descriptor, F_DUPFD_CLOEXEC, 2 * kept);
        const int orders = ::fcntl(ends[1], F_DUPFD_CLOEXEC, 2 * kept);
        ::posix_spawn_file_actions_adddup2(&a.files, orders, STDIN_FILENO);
        ::posix_spawn_file_actions_addopen(&a.files, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
        ::posix_spawn_file_actions_addopen(&a.files, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
        ::posix_spawn_file_actions_adddup2(&a.files, stream, kept);
        ::posix_spawn_file_actions_addclosefrom_np(&a.files, kept + 1);
        std::string script = fmt::format("read -r release || exec /bin/sleep {:.3f}", lasts.count());
        std::string shell = "sh", option = "-c";
        std::array<char*, 4> arguments{shell.data(), option.data(), script.data(), nullptr};
        std::array<char*, 1> environment{nullptr};
        error = ::posix_spawn(&controller_, "/bin/sh", &a.files, &a.attributes, arguments.data(),
                              environment.data());
        ::close(stream);
        ::close(orders);
        ::close(ends[1]);
    }
    release_ = ends[0];
    if (error == 0) return;
    if (release_ >= 0) ::close(release_);
    throw DeviceError{std::string{"cannot start the process that plays out the drive: "} +
                      std::strerror(error)};
}

StreamKeeper::~StreamKeeper() {
    static_cast<void>(::send(release_, "\n", 1, MSG_NOSIGNAL));
    ::close(release_);
    while (::waitpid(controller_, nullptr, 0) < 0 && errno == EINTR) {
    }
}

}  // namespace shaker::alsa

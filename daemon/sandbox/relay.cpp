#include "daemon/sandbox/relay.hpp"

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <string>
#include <string_view>
#include <utility>

#include "drivers/errors.hpp"
#include "drivers/text/printable.hpp"

namespace shaker::sandbox {

namespace {

void close_end(int& fd) noexcept {
    if (fd >= 0) ::close(fd);
    fd = -1;
}

void write_all(int to, std::string_view text) noexcept {
    while (!text.empty()) {
        const ssize_t n = ::write(to, text.data(), text.size());
        if (n < 0 && errno == EAGAIN) {  // somebody else made it non-blocking
            pollfd ready{.fd = to, .events = POLLOUT, .revents = 0};
            ::poll(&ready, 1, -1);
        } else if (n < 0 && errno != EINTR) {
            return;
        }
        text.remove_prefix(n > 0 ? static_cast<std::size_t>(n) : 0);
    }
}

// One stream of output; a character that is cut at the end of a read waits for its rest.
class Stream {
public:
    Stream(int& from, int to) : from_{from}, to_{to} {}
    [[nodiscard]] bool open() const noexcept { return from_ >= 0; }
    [[nodiscard]] int from() const noexcept { return from_; }
    void copy() {
        std::array<char, 65536> bytes;
        const ssize_t n = ::read(from_, bytes.data(), bytes.size());
        if (n < 0 && errno == EINTR) return;
        if (n <= 0) {
            write_all(to_, printable(waiting_, true));
            return close_end(from_);
        }
        waiting_.append(bytes.data(), static_cast<std::size_t>(n));
        const std::size_t whole = waiting_.size() - unfinished_bytes(waiting_);
        write_all(to_, printable(std::string_view{waiting_}.substr(0, whole), true));
        waiting_.erase(0, whole);
    }

private:
    int& from_;
    int to_;
    std::string waiting_;
};

// Writing to a closed pipe reports EPIPE instead of ending this process.
class WithoutSigpipe {
public:
    WithoutSigpipe() {
        struct sigaction ignored {};
        ignored.sa_handler = SIG_IGN;
        sigaction(SIGPIPE, &ignored, &before_);
    }
    ~WithoutSigpipe() { sigaction(SIGPIPE, &before_, nullptr); }
    WithoutSigpipe(const WithoutSigpipe&) = delete;
    WithoutSigpipe& operator=(const WithoutSigpipe&) = delete;

private:
    struct sigaction before_ {};
};

}  // namespace

Relay::Relay() {
    for (Pipe* pipe : {&out_, &err_}) {
        std::array<int, 2> ends{};
        if (::pipe2(ends.data(), O_CLOEXEC) < 0)
            throw DeviceError{std::string{"a pipe for a file reader: "} + std::strerror(errno)};
        *pipe = {ends[0], ends[1]};
    }
}

Relay::~Relay() {
    for (Pipe* pipe : {&out_, &err_}) {
        close_end(pipe->from);
        close_end(pipe->to);
    }
}

void Relay::send() {
    const bool watched = ::isatty(STDOUT_FILENO) == 1;
    const int nothing = ::open("/dev/null", O_RDONLY | O_CLOEXEC);
    if (nothing < 0 || ::dup2(nothing, STDIN_FILENO) < 0 || ::dup2(out_.to, STDOUT_FILENO) < 0 ||
        ::dup2(err_.to, STDERR_FILENO) < 0)
        throw DeviceError{std::string{"the output of a file reader: "} + std::strerror(errno)};
    if (nothing > STDERR_FILENO) ::close(nothing);
    for (Pipe* pipe : {&out_, &err_}) {
        close_end(pipe->from);
        close_end(pipe->to);
    }
    if (watched) std::setvbuf(stdout, nullptr, _IOLBF, BUFSIZ);  // as on a terminal
}

void Relay::receive() {
    const WithoutSigpipe quiet;
    close_end(out_.to);
    close_end(err_.to);
    std::array streams{Stream{out_.from, STDOUT_FILENO}, Stream{err_.from, STDERR_FILENO}};
    while (streams[0].open() || streams[1].open()) {
        std::array<pollfd, 2> ready{{{.fd = streams[0].from(), .events = POLLIN, .revents = 0},
                                     {.fd = streams[1].from(), .events = POLLIN, .revents = 0}}};
        if (::poll(ready.data(), ready.size(), -1) < 0 && errno != EINTR) return;
        for (std::size_t i = 0; i < streams.size(); ++i)
            if (ready[i].revents != 0) streams[i].copy();
    }
}

}  // namespace shaker::sandbox

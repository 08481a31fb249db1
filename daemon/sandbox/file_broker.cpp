#include "daemon/sandbox/file_broker.hpp"

#include <fcntl.h>
#include <linux/seccomp.h>
#include <poll.h>
#include <seccomp.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/uio.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <climits>
#include <cstring>
#include <memory>
#include <optional>

#include "drivers/errors.hpp"

namespace shaker::sandbox {

namespace {

using Rules = std::unique_ptr<void, decltype(&seccomp_release)>;

constexpr std::array asked_calls{SCMP_SYS(open),   SCMP_SYS(openat),   SCMP_SYS(creat),
                                 SCMP_SYS(mkdir),  SCMP_SYS(mkdirat),  SCMP_SYS(rmdir),
                                 SCMP_SYS(unlink), SCMP_SYS(unlinkat), SCMP_SYS(rename),
                                 SCMP_SYS(link),   SCMP_SYS(renameat), SCMP_SYS(renameat2)};

// A message with one descriptor.
struct Parcel {
    Parcel() {
        message.msg_iov = &part;
        message.msg_iovlen = 1;
        message.msg_control = space.data();
        message.msg_controllen = space.size();
    }
    char byte = 0;
    iovec part{&byte, 1};
    alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(int))> space{};
    msghdr message{};
};

bool send_descriptor(int channel, int fd) {
    Parcel parcel;
    cmsghdr* const head = CMSG_FIRSTHDR(&parcel.message);
    head->cmsg_level = SOL_SOCKET;
    head->cmsg_type = SCM_RIGHTS;
    head->cmsg_len = CMSG_LEN(sizeof fd);
    std::memcpy(CMSG_DATA(head), &fd, sizeof fd);
    return ::sendmsg(channel, &parcel.message, 0) == 1;
}

int received_descriptor(int channel) {
    Parcel parcel;
    if (::recvmsg(channel, &parcel.message, MSG_CMSG_CLOEXEC) != 1) return -1;
    const cmsghdr* const head = CMSG_FIRSTHDR(&parcel.message);
    if (head == nullptr || head->cmsg_type != SCM_RIGHTS) return -1;
    int fd = -1;
    std::memcpy(&fd, CMSG_DATA(head), sizeof fd);
    return fd;
}

// Text in the memory of another process, read page by page.
std::optional<std::string> text_at(pid_t pid, std::uint64_t address) {
    constexpr std::size_t page = 4096;
    std::string text;
    std::array<char, page> bytes{};
    while (text.size() < PATH_MAX) {
        iovec here{bytes.data(), page - address % page}, there{};
        there = {reinterpret_cast<void*>(address), here.iov_len};  // NOLINT: an address over there
        const ssize_t n = ::process_vm_readv(pid, &here, 1, &there, 1, 0);
        if (n <= 0) return std::nullopt;
        const auto* const end = std::find(bytes.data(), bytes.data() + n, '\0');
        text.append(bytes.data(), static_cast<std::size_t>(end - bytes.data()));
        if (end != bytes.data() + n) return text;
        address += static_cast<std::uint64_t>(n);
    }
    return std::nullopt;
}

// Arguments of a system call that names files.
class Arguments {
public:
    Arguments(pid_t pid, const seccomp_data& call) : pid_{pid}, call_{call} {}
    [[nodiscard]] int number(unsigned i) const { return static_cast<int>(call_.args[i]); }
    [[nodiscard]] mode_t mode(unsigned i) const { return static_cast<mode_t>(call_.args[i]); }
    /// Empty if it cannot be read, which no call accepts.
    [[nodiscard]] std::string path(unsigned i) const { return text_at(pid_, call_.args[i]).value_or(""); }
    /// The same, relative to the folder before it. Only the current folder is known here.
    [[nodiscard]] std::string path_at(unsigned i) const {
        std::string text = path(i);
        return number(i - 1) == AT_FDCWD || text.starts_with('/') ? text : "";
    }

private:
    pid_t pid_;
    const seccomp_data& call_;
};

// A descriptor for the child, or the call's result.
int obey(const AllowedFiles& files, pid_t pid, const seccomp_data& call) {
    const Arguments of{pid, call};
    switch (call.nr) {
        case SCMP_SYS(open):
            return files.open(pid, of.path(0), of.number(1), of.mode(2));
        case SCMP_SYS(openat):
            return files.open(pid, of.path_at(1), of.number(2), of.mode(3));
        case SCMP_SYS(creat):
            return files.open(pid, of.path(0), O_WRONLY | O_CREAT | O_TRUNC, of.mode(1));
        case SCMP_SYS(mkdir):
            return files.make_folder(of.path(0), of.mode(1));
        case SCMP_SYS(mkdirat):
            return files.make_folder(of.path_at(1), of.mode(2));
        case SCMP_SYS(rmdir):
            return files.remove(of.path(0), AT_REMOVEDIR);
        case SCMP_SYS(unlink):
            return files.remove(of.path(0), 0);
        case SCMP_SYS(unlinkat):
            return files.remove(of.path_at(1), of.number(2) & AT_REMOVEDIR);
        case SCMP_SYS(rename):
            return files.rename(of.path(0), of.path(1), 0);
        case SCMP_SYS(renameat):
            return files.rename(of.path_at(1), of.path_at(3), 0);
        case SCMP_SYS(renameat2):
            return files.rename(of.path_at(1), of.path_at(3), static_cast<unsigned>(of.number(4)));
        case SCMP_SYS(link):
            return files.link(of.path(0), of.path(1));
        default:
            return -ENOSYS;
    }
}

bool opens(int call) { return call == SCMP_SYS(open) || call == SCMP_SYS(openat) || call == SCMP_SYS(creat); }

int flags_of(const seccomp_data& call) {
    return call.nr == SCMP_SYS(creat) ? 0 : static_cast<int>(call.args[call.nr == SCMP_SYS(open) ? 1 : 2]);
}

}  // namespace

FileBroker::FileBroker(const FileRights& allowed) : files_{allowed} {
    std::array<int, 2> ends{};
    if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) < 0)
        throw DeviceError{std::string{"a channel for a file reader: "} + std::strerror(errno)};
    parents_ = Descriptor{ends[0]};
    childs_ = Descriptor{ends[1]};
}

std::string FileBroker::ask_parent() {
    parents_.close();
    const Descriptor channel = std::move(childs_);
    const Rules rules{seccomp_init(SCMP_ACT_ALLOW), seccomp_release};
    int error = rules ? 0 : -EINVAL;
    for (const int call : asked_calls)
        if (error == 0) error = seccomp_rule_add(rules.get(), SCMP_ACT_NOTIFY, call, 0);
    if (error == 0) error = seccomp_attr_set(rules.get(), SCMP_FLTATR_API_SYSRAWRC, 1);
    if (error == 0) error = seccomp_load(rules.get());
    if (error != 0) return std::string{"seccomp: "} + std::strerror(-error);
    const Descriptor calls{seccomp_notify_fd(rules.get())};
    return send_descriptor(channel.get(), calls.get()) ? "" : std::string{"seccomp: "} + std::strerror(errno);
}

void FileBroker::close() noexcept {
    for (Descriptor* all : {&parents_, &childs_, &calls_, &child_}) all->close();
}

void FileBroker::started(pid_t child) noexcept {
    childs_.close();
    child_ = Descriptor{static_cast<int>(::syscall(SYS_pidfd_open, child, 0))};
}

void FileBroker::receive_calls() {
    calls_ = Descriptor{received_descriptor(parents_.get())};
    parents_.close();
}

void FileBroker::serve() {
    if (calls_.get() < 0) return receive_calls();
    pollfd ready{.fd = calls_.get(), .events = POLLIN, .revents = 0};
    if (::poll(&ready, 1, 0) == 1 && (ready.revents & POLLIN) == 0) return calls_.close();  // the child ended
    seccomp_notif call{};
    if (::ioctl(calls_.get(), SECCOMP_IOCTL_NOTIF_RECV, &call) < 0) return;  // it was killed meanwhile
    int result = obey(files_, static_cast<pid_t>(call.pid), call.data);
    seccomp_notif_resp answer{.id = call.id, .val = 0, .error = 0, .flags = 0};
    const Descriptor opened{opens(call.data.nr) ? result : -1};
    if (opened.get() >= 0) {
        seccomp_notif_addfd given{};
        given.id = call.id;
        given.srcfd = static_cast<std::uint32_t>(opened.get());
        given.newfd_flags = static_cast<std::uint32_t>(flags_of(call.data) & O_CLOEXEC);
        result = ::ioctl(calls_.get(), SECCOMP_IOCTL_NOTIF_ADDFD, &given);
        if (result < 0) result = -errno;
    }
    answer.error = std::min(result, 0);
    answer.val = std::max(result, 0);
    ::ioctl(calls_.get(), SECCOMP_IOCTL_NOTIF_SEND, &answer);
}

}  // namespace shaker::sandbox

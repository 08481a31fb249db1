#pragma once
// Opens files for a confined child on a kernel without Landlock (Linux 5.9 and later). The parent answers the
// child's system calls that open or change files by name.
#include <string>

#include "daemon/sandbox/allowed_files.hpp"
#include "daemon/sandbox/descriptor.hpp"

namespace shaker::sandbox {

class FileBroker {
public:
    /// Before the child is started. Throws DeviceError.
    explicit FileBroker(const FileRights& allowed);

    /// In the child: from now on this thread and those it starts open and change only files that the parent
    /// allows. The parent must be able to read the memory of this process. Needs PR_SET_NO_NEW_PRIVS. Returns
    /// an empty text, or the reason for which the system does not support this.
    std::string ask_parent();
    /// In the child, before ask_parent(): the descriptor that it needs.
    [[nodiscard]] int fd_of_child() const noexcept { return childs_.get(); }
    /// In either: no call is served any more.
    void close() noexcept;

    /// In the parent, once the child has been started.
    void started(pid_t child) noexcept;
    /// In the parent: has data when serve() is to be called; -1: never again.
    [[nodiscard]] int fd() const noexcept { return calls_.get() >= 0 ? calls_.get() : parents_.get(); }
    /// In the parent: has data when the child has ended and close() is to be called; -1: never. Older kernels
    /// keep fd() open until the child has been waited for.
    [[nodiscard]] int end() const noexcept { return child_.get(); }
    /// In the parent: answers one system call.
    void serve();

private:
    void receive_calls();

    AllowedFiles files_;
    Descriptor parents_, childs_;  // ends of the channel for calls_
    Descriptor calls_, child_;
};

}  // namespace shaker::sandbox

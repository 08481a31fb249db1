#pragma once
// What a process that reads files of unknown origin may still ask of the kernel.
#include <string>

namespace shaker {

/// From here on, until its end, this thread and those it starts are refused (EPERM) sockets, other programs
/// and processes, their memory and signals, mounts, kernel interfaces that files do not need, and, unless
/// `writes_files`, every change to the file system; what is open stays open. Returns an empty text, or why
/// the system does not do this.
std::string filter_syscalls(bool writes_files);

}  // namespace shaker

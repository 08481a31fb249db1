#pragma once
// System calls allowed to a process that reads files of unknown origin.
#include <string>

namespace shaker::sandbox {

/// From now on, this thread and those it starts are refused (EPERM): sockets, other programs, other processes
/// with their memory and signals, mounts, kernel interfaces that files do not need, and, unless
/// `writes_files`, every change of the file system. Open files stay open. Returns an empty text, or the
/// reason for which the system does not support this.
std::string filter_syscalls(bool writes_files);

}  // namespace shaker::sandbox

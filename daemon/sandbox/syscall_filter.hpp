#pragma once
// System calls allowed to a process that reads files of unknown origin.
#include <string>

namespace shaker::sandbox {

/// From now on, this thread and those it starts may read and, if `writes_files`, write files, use memory,
/// start threads, and ask for the time and their own state. Every other system call kills the process
/// (SIGSYS): also all that are newer than this list, of 32 bits or of x32. Opening a file for writing without
/// `writes_files` is refused (EACCES). Open files stay open. Returns an empty text, or the reason for which
/// the system does not support this.
std::string filter_syscalls(bool writes_files);

/// From now on, this thread and those it starts, also in other programs, have no sockets and cannot look into
/// other processes: these calls answer EACCES. Needs PR_SET_NO_NEW_PRIVS. Returns as filter_syscalls().
std::string deny_network();

}  // namespace shaker::sandbox

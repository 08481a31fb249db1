#pragma once
// What a process may do that reads files of unknown origin: the files that it may open, by Landlock
// (Linux 5.13 and later), and the system calls.
#include <filesystem>
#include <string>
#include <vector>

namespace shaker::sandbox {

/// Files and folders with all they contain. Those that do not exist are passed over.
struct FileRights {
    std::vector<std::filesystem::path> lists{};   // names of files in these folders may be read
    std::vector<std::filesystem::path> reads{};   // may be read
    std::vector<std::filesystem::path> writes{};  // may also be written; in folders, files may be created,
                                                  // renamed and removed. Links are passed over, too
    std::vector<std::filesystem::path> runs{};    // may be read and executed
};

/// From now on, this thread and those it starts open no other files than these, those of the system that
/// libraries open while a file is read, and the process's own state. Files that are open stay open. Names,
/// sizes and times of other files can still be seen. On newer kernels they also open no TCP connection (6.7),
/// send no signal to, and reach no abstract socket of, other processes (6.12). Needs PR_SET_NO_NEW_PRIVS.
/// Returns an empty text, or the reason for which the system does not support this.
std::string restrict_files(const FileRights& allowed);

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

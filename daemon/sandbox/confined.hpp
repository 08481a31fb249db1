#pragma once
// Reads files of unknown origin in a child process with few rights. A crash is one failed command; an
// attacker in the child has no network, no other program, no other process, and only the files that are
// named.
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "daemon/sandbox/rights.hpp"

namespace shaker::sandbox {

/// Rights of a confined child.
struct Confinement {
    std::uint64_t memory_bytes;  // address space; no limit under a sanitiser, which reserves terabytes
    std::uint64_t processor_s;   // of all its threads together
    FileRights files{};
    std::vector<int> keeps{};         // descriptors that stay open; all others except 0 to 2 are closed
    std::function<void()> prepare{};  // runs before the rights are given up, for example to load libraries
    bool warns = true;                // when the system cannot restrict files or system calls
};

/// Limits far above the needs of an intact file of this size: 4 GiB plus 20 times the file; 600 s plus 60 s
/// per GiB of it and its pictures. The child may read the file and its pictures.
Confinement confinement_for(const std::filesystem::path& file);

/// Exit of a confined child.
struct ChildEnd {
    int status = 0;          // exit status; undefined if a signal ended the child
    int signal = 0;          // number of the signal that ended the child; 0: none
    double processor_s = 0;  // used
};

/// Runs `work` in a confined child and waits for it. Its standard input is empty; its standard output and
/// error are copied to those of this process, made printable. It reports exceptions of `work` as
/// exit_status_of() does, and is killed when the calling thread ends. It works on a copy of the memory:
/// changes are not seen here. Until it ends, no process without privileges can read or write the memory of
/// this one. Call while the process has a single thread: the child would inherit the locks of others but not
/// the threads. `file` is named in messages. Throws DeviceError when no child can be started.
ChildEnd run_confined(const std::string& file, const Confinement& allowed, const std::function<int()>& work);

/// The same for reading `file`; returns the exit status. Throws InputError when the reader crashed, made a
/// system call that no reader needs, or exceeded its processor time, and std::runtime_error when another
/// process ended it.
int confined(const std::string& file, const Confinement& allowed, const std::function<int()>& work);

/// A text from a confined child.
struct Answer {
    int status = 0;    // exit status; the text is empty if it is not 0
    std::string text;  // at most 1 MiB
};

/// The same for `work` that returns a text. Check the text before use: an attacker may control `work`.
/// Throws InputError when it is longer than 1 MiB.
Answer ask_confined(const std::string& file, const Confinement& allowed,
                    const std::function<std::string()>& work);

}  // namespace shaker::sandbox

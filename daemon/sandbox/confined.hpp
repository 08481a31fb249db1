#pragma once
// Reads files of unknown origin in a child process with few rights. A crash is one failed command; an
// attacker in the child has no network, no other program and no file to write.
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

namespace shaker::sandbox {

/// Rights of a confined child.
struct Confinement {
    std::uint64_t memory_bytes;  // address space; no limit under a sanitiser, which reserves terabytes
    std::uint64_t processor_s;   // of all its threads together
    bool writes_files = false;   // may open files for writing, and create, rename and remove them
};

/// Limits far above the needs of an intact file of this size: 4 GiB plus 20 times the file; 600 s plus 60 s
/// per GiB of it and its pictures.
Confinement confinement_for(const std::filesystem::path& file);

/// Exit of a confined child.
struct ChildEnd {
    int status = 0;          // exit status; undefined if a signal ended the child
    int signal = 0;          // number of the signal that ended the child; 0: none
    double processor_s = 0;  // used
};

/// Runs `work` in a confined child and waits for it. The child shares standard output and error, reports
/// exceptions of `work` as exit_status_of() does, and is killed when the calling thread ends. It works on a
/// copy of the memory: changes are not seen here. Call while the process has a single thread: the child would
/// inherit the locks of others but not the threads. `file` is named in messages. Throws DeviceError when no
/// child can be started.
ChildEnd run_confined(const std::string& file, const Confinement& allowed, const std::function<int()>& work);

/// The same for reading `file`; returns the exit status. Throws InputError when the reader crashed or
/// exceeded its processor time, and std::runtime_error when another process ended it.
int confined(const std::string& file, const Confinement& allowed, const std::function<int()>& work);

}  // namespace shaker::sandbox

#pragma once
// Files of unknown origin are read in a child process that can do little. A crash there is one failed
// command; whoever took the child over finds no network, no program to start and no file to write.
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

namespace shaker {

/// What a confined child may use.
struct Confinement {
    std::uint64_t memory_bytes;  // of address space; no limit under a sanitiser, which reserves terabytes
    std::uint64_t processor_s;   // of all its threads together
    bool writes_files = false;   // may open files for writing, make, rename and remove them
};

/// Far more than a sound file of this size needs: 4 GiB and 20 times the file, 600 s and 60 s a GiB of it
/// and of its pictures.
Confinement confinement_for(const std::filesystem::path& file);

/// How a confined child ended.
struct ChildEnd {
    int status = 0;          // exit status; meaningless when a signal ended it
    int signal = 0;          // that ended it; 0: none
    double processor_s = 0;  // used
};

/// Does `work` in a confined child and waits for it. The child has standard output and error of this process,
/// says what `work` throws as exit_status_of() does, and is killed when the calling thread ends. What is in
/// memory is copied: nothing that `work` changes is seen here. Call it while this process has one thread: of
/// others the child would have the locks but not the threads. `file` is named in messages. Throws DeviceError
/// when there is no child to be had.
ChildEnd run_confined(const std::string& file, const Confinement& allowed, const std::function<int()>& work);

/// The same, for reading `file`: returns the exit status. Throws InputError when the reader crashed or used
/// up its processor time, and std::runtime_error when somebody else ended it.
int confined(const std::string& file, const Confinement& allowed, const std::function<int()>& work);

}  // namespace shaker

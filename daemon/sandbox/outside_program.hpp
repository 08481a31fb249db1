#pragma once
// Runs another program that reads files of unknown origin, with few rights.
#include <cstdint>
#include <string>
#include <vector>

#include "daemon/sandbox/rights.hpp"

namespace shaker::sandbox {

struct OutsideProgram {
    std::vector<std::string> words;       // absolute path of the program, and its arguments
    FileRights files{};                   // besides those of the system that it needs to run
    std::vector<std::string> settings{};  // its environment, NAME=VALUE
    std::uint64_t processor_s = 600;
};

/// Starts the program and waits for its end. It has no network, no other file of its user than those named,
/// an empty standard input, and none of this process's descriptors; what it prints is made printable. It is
/// killed when the calling thread ends. Returns its exit status, 128 + n when signal n ended it. Throws
/// DeviceError when it cannot be started.
int run_outside(const OutsideProgram& program);

}  // namespace shaker::sandbox

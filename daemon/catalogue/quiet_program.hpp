#pragma once
// Runs a program that may take only what nothing else needs: processor and disk at idle priority.
#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace shaker::catalogue {

struct QuietProgram {
    std::vector<std::string> words;  // path of the program, and its arguments
    std::size_t most_bytes = 0;      // of its standard output, and of its standard error; the rest is dropped
    std::chrono::seconds longest{0};  // then it is killed
};

/// How the program ended.
struct QuietEnd {
    int status = 0;     // exit status; 128 + n when signal n ended it
    bool late = false;  // killed after `longest`
    std::string out, err;
};

/// Runs the program (SCHED_IDLE, whose disk access is idle too) with an empty standard input and no other
/// descriptor of this process. The calling process may have threads. go_on: asked ten times a second; when it
/// returns false, the program is killed and the answer is empty. DeviceError when it cannot be started.
std::optional<QuietEnd> run_quietly(const QuietProgram& program, const std::function<bool()>& go_on);

}  // namespace shaker::catalogue

#pragma once
// With what the program ends, and what it says when it fails.
#include <array>
#include <functional>

namespace shaker {

inline constexpr int exit_ok = 0;
inline constexpr int exit_failure = 1;  // something that should not happen
inline constexpr int exit_input = 2;    // command line, settings or a file's content; nothing was written
inline constexpr int exit_device = 3;   // a device or the disk failed
inline constexpr int exit_tripped = 5;  // a limit stopped the drive
inline constexpr int exit_not_identical = 4;  // replay: the results are not the recorded ones

struct ExitMeaning {
    int number;
    const char* meaning;
};
/// For help and manual page.
inline constexpr std::array exit_meanings{
    ExitMeaning{exit_ok, "done"},
    ExitMeaning{exit_failure, "failure"},
    ExitMeaning{exit_input, "input refused, nothing written"},
    ExitMeaning{exit_device, "device or disk failed"},
    ExitMeaning{exit_not_identical, "replay is not identical, or a finished file is not what was written"},
    ExitMeaning{exit_tripped, "a limit stopped the drive"},
};

/// What `work` returns, or the status that belongs to what it throws, which is said on standard error.
int exit_status_of(const std::function<int()>& work);

}  // namespace shaker

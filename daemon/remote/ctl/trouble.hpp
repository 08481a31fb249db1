#pragma once
// How shakerctl may fail besides wrong use (InputError), and with what exit status.
#include <array>
#include <stdexcept>

namespace shaker::ctl {

/// The daemon said no; its own words.
struct Refused : std::runtime_error {
    using std::runtime_error::runtime_error;
};
/// No daemon answered: the address and the system's words.
struct NotReached : std::runtime_error {
    using std::runtime_error::runtime_error;
};
/// Of these: nobody listens there, or not yet.
struct NobodyListens : NotReached {
    using NotReached::NotReached;
};
struct TimedOut : std::runtime_error {
    using std::runtime_error::runtime_error;
};
/// Standard output takes no more.
struct NotWritten : std::runtime_error {
    using std::runtime_error::runtime_error;
};

inline constexpr int exit_done = 0;
inline constexpr int exit_refused = 1;
inline constexpr int exit_wrong_use = 2;
inline constexpr int exit_not_reached = 69;  // as sysexits.h numbers these
inline constexpr int exit_failure = 70;
inline constexpr int exit_not_written = 74;
inline constexpr int exit_timed_out = 75;

struct ExitStatus {
    int number;
    const char* meaning;
};
inline constexpr std::array exit_statuses{
    ExitStatus{exit_done, "done"},
    ExitStatus{exit_refused, "the daemon refused, or a limit stopped the drive; why is on standard error"},
    ExitStatus{exit_wrong_use, "wrong use; nothing was asked of the daemon"},
    ExitStatus{exit_not_reached, "the daemon was not reached, or did not answer within 5 s"},
    ExitStatus{exit_failure, "a failure that should not happen"},
    ExitStatus{exit_not_written, "standard output could not be written"},
    ExitStatus{exit_timed_out, "timed out waiting"},
};

}  // namespace shaker::ctl

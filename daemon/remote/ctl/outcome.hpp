#pragma once
// Output of shakerctl, its errors besides wrong use (InputError), and its exit statuses.
#include <array>
#include <stdexcept>
#include <string_view>

#include "daemon/manual/command.hpp"

namespace shaker::ctl {

/// The daemon refused an order; its message.
struct Refused : std::runtime_error {
    using std::runtime_error::runtime_error;
};
/// No daemon answered: the address and the system's message.
struct NotReached : std::runtime_error {
    using std::runtime_error::runtime_error;
};
/// No program listens at the address, or not yet.
struct NobodyListens : NotReached {
    using NotReached::NotReached;
};
struct TimedOut : std::runtime_error {
    using std::runtime_error::runtime_error;
};
/// Standard output could not be written.
struct NotWritten : std::runtime_error {
    using std::runtime_error::runtime_error;
};

inline constexpr int exit_done = 0;
inline constexpr int exit_refused = 1;
inline constexpr int exit_wrong_use = 2;
inline constexpr int exit_not_reached = 69;  // numbers from sysexits.h
inline constexpr int exit_failure = 70;
inline constexpr int exit_not_written = 74;
inline constexpr int exit_timed_out = 75;

inline constexpr std::array exit_statuses{
    manual::ExitStatus{exit_done, "done", true},
    manual::ExitStatus{exit_refused,
                       "the daemon refused, or a limit stopped the drive; standard error has the reason"},
    manual::ExitStatus{exit_wrong_use, "wrong use; nothing was sent to the daemon", true},
    manual::ExitStatus{exit_not_reached, "the daemon was not reached, or did not answer within 5 s"},
    manual::ExitStatus{exit_failure, "internal failure", true},
    manual::ExitStatus{exit_not_written, "standard output could not be written", true},
    manual::ExitStatus{exit_timed_out, "timed out waiting"},
};

/// Writes to standard output at once. Throws NotWritten with the message of the C library.
void print(std::string_view text);

/// True if the reader of standard output has closed it.
bool nobody_reads() noexcept;

}  // namespace shaker::ctl

#pragma once
// Exit statuses: the form in which each program lists its own, those of shakerd, and their place in error
// handling.
#include <array>
#include <functional>
#include <string_view>

namespace shaker::manual {

struct ExitStatus {
    int number;
    std::string_view meaning;
    bool of_every_command = false;  // false: only of the commands whose rows list it
};

inline constexpr int exit_ok = 0;
inline constexpr int exit_failure = 1;  // an error that should not happen
inline constexpr int exit_input =
    2;  // command line, settings or a file's content; or data that cannot be reduced
inline constexpr int exit_device = 3;         // a device or the disk failed
inline constexpr int exit_tripped = 5;        // a limit stopped the drive
inline constexpr int exit_signal = 128;       // plus the number of the signal that ended a run softly
inline constexpr int exit_not_identical = 4;  // replay: the results are not the recorded ones

/// The exit statuses of shakerd.
inline constexpr std::array exit_meanings{
    ExitStatus{exit_ok, "done", true},
    ExitStatus{exit_failure, "internal failure", true},
    ExitStatus{exit_input, "input refused, nothing was written; or the measured data cannot be reduced",
               true},
    ExitStatus{exit_device, "a device or the disk failed"},
    ExitStatus{exit_not_identical,
               "replay: the results differ from the recorded ones; recover: a finished file was changed"},
    ExitStatus{exit_tripped, "a limit stopped the drive"},
    ExitStatus{exit_signal, "plus the signal's number: a signal ended the run; the drive was stopped softly"},
};

/// Returns the result of `work`, or the status for the exception that it throws; logs the exception's
/// message.
int exit_status_of(const std::function<int()>& work);

}  // namespace shaker::manual

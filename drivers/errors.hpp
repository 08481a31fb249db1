#pragma once
// Exceptions for errors that a person can correct. A message names the item, its value and what is
// allowed.
#include <stdexcept>
#include <string>
#include <system_error>

namespace shaker {

/// Wrong input: a setting, the content of a file, a command line. Exit status 2.
struct InputError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// A device, or a file that stands for one, failed. Message: its name and the C library's error text.
/// Exit status 3.
struct DeviceError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// The drive was stopped because a limit was exceeded: which one, by how much. Exit status 5.
struct TripError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// A signal ended a run before its measurement was complete. Exit status 128 + signal.
struct Interrupted : std::runtime_error {
    Interrupted(int number, const std::string& what) : std::runtime_error{what}, signal{number} {}
    int signal;
};

/// The system's text for an errno.
inline std::string system_text(int error) { return std::generic_category().message(error); }

}  // namespace shaker

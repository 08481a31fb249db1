#pragma once
// What is thrown where a human can act. Each message names the thing, the value and what is allowed.
#include <stdexcept>

namespace shaker {

/// The user's input is wrong: a setting, a file's content, a command line. Exit status 2.
struct InputError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// A device (or a file acting as one) failed: its name and the C library's own words. Exit status 3.
struct DeviceError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// The drive was stopped because a limit was violated: what, by how much. Exit status 5.
struct TripError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

}  // namespace shaker

#pragma once
// The first day of a bench with real devices: tests with the operator, and the record that lets a service
// drive it.
#include <functional>
#include <string>

#include "drivers/devices.hpp"

namespace shaker::commissioning {

struct Settings {
    std::string rig;            // file
    double frequency_hz = 20;   // of the drive
    double level = 0.02;        // peak of the drive, share of the DAC's full scale
    std::string tested_text{};  // the rig file as the self-test before has opened it; empty: unknown
    std::string self_test{};    // result of that self-test
    /// Called once with the opened devices, before they are used; may be empty.
    std::function<void(Rig&)> fit{};
};

/// The operator: shown text, and the answer to a question; empty at the end of the input.
struct Operator {
    std::function<void(const std::string&)> show;
    std::function<std::string(const std::string&)> ask;
    std::function<void()> rethrow;  // throws when the operator has interrupted the program
};

/// Leads through the tests: polarity by hand, enable output and abort input where the rig has them, gain by a
/// known step, limits crossed on purpose, the ramp seen, an abort from each door timed, the emergency stop.
/// Writes the record of the rig file as it was opened when all passed, and
/// returns true. When a record of this rig file exists and only the accelerometer was calibrated again, with
/// gains that moved less than 5 %, only the gain is tested. False, with the reason shown, when the operator
/// denies one. InputError for a simulated rig and a rig file that has changed since its self-test; after an
/// interruption the drive stops softly, then rethrow() throws from here. DeviceError when the bench does not
/// do what a test demands.
bool commission(const Settings& settings, const Operator& person);

}  // namespace shaker::commissioning

#pragma once
// Controls of a sound card, which other programs can change.
#include <functional>
#include <map>
#include <string>
#include <vector>

namespace shaker {

struct Mixer {
    std::string card;  // name of its control device
    /// A line "NAME = VALUES" for each; "- " before those that change by themselves or cannot be set.
    std::string controls;
};

/// Thread safety: one thread.
struct MixerDevice {
    std::string card;
    std::function<Mixer()> read{};  // now; DeviceError
    /// Sets what has other values, and returns the names. DeviceError.
    std::function<std::vector<std::string>(const Mixer&)> restore{};
};

/// Values by name, without those behind "- ".
std::map<std::string, std::string> settable_controls(const std::string& controls);

/// Differences of two Mixer::controls in what can be set, "NAME is 20,20 instead of 80,80" for each; `then`:
/// as it should be.
std::vector<std::string> mixer_changes(const std::string& then, const std::string& now);

}  // namespace shaker

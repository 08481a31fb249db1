#pragma once
// Controls of a sound card, which other programs can change.
#include <functional>
#include <map>
#include <string>
#include <vector>

namespace shaker {

/// Thread safety: one thread.
struct MixerDevice {
    std::string card;  // name of its control device
    /// All controls now, a line "NAME = VALUES" for each; "- " before those that change by themselves or
    /// cannot be set. DeviceError.
    std::function<std::string()> read{};
    /// Sets what is not as in such lines, and returns the names. DeviceError.
    std::function<std::vector<std::string>(const std::string&)> restore{};
};

/// Values by name, without those behind "- ".
std::map<std::string, std::string> settable_controls(const std::string& controls);

/// Differences of two texts of MixerDevice::read in what can be set, "NAME is 20,20 instead of 80,80" for
/// each; `then`: as it should be.
std::vector<std::string> mixer_changes(const std::string& then, const std::string& now);

}  // namespace shaker

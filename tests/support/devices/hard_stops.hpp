#pragma once
// Aborts at random phases of a drive on a real or mock DAC, with what should be heard.
#include <cstdint>
#include <vector>

#include "drivers/devices.hpp"

namespace shaker::test {

/// Times are from the abort, s, to the sample's place at the converter.
struct HardStop {
    std::int64_t first = 0;       // DAC sample at which the ramp begins
    std::int64_t ramp = 0;        // samples
    std::int64_t taken_back = 0;  // samples
    double ramp_s = 0, silent_s = 0;
};

struct HardStops {
    std::vector<HardStop> stops;
    std::vector<double> volts;  // of every DAC sample, from the recorded changes
    /// Largest difference of neighbouring samples in V: while driven, and from each stop on.
    double step_driven = 0, step_stopped = 0;
    DeviceCounts counts;
};

/// Drives two harmonics at random frequencies of 50 to 150 Hz, and gives `count` aborts at random times from
/// a thread of its own. After each the output is silent for a while and is cleared. Throws DeviceError.
HardStops stop_hard(Dac& dac, int count, unsigned seed);

}  // namespace shaker::test

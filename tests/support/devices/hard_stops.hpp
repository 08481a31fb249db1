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
    bool stalled = false;  // the machine stood still meanwhile (StallProbe)
};

struct HardStops {
    std::vector<HardStop> stops;
    std::vector<double> volts;  // of every DAC sample, from the recorded changes
    double largest_step = 0;    // V, between neighbouring samples from the start of a stop to its end
    double own_step = 0;        // V, at most, of the drives and of the ramp that multiplies them
    DeviceCounts counts;
};

/// Drives two harmonics at random frequencies of 50 to 150 Hz, and gives `count` aborts at random times from
/// a thread of its own. After each the output is silent for a while and is cleared. Throws DeviceError.
HardStops stop_hard(Dac& dac, int count, unsigned seed);

}  // namespace shaker::test

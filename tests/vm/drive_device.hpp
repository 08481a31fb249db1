#pragma once
// Operations of the virtual machine's jobs on an open device of each kind, with their results.
#include <cstdint>
#include <functional>
#include <string>

#include "drivers/devices.hpp"

namespace shaker {

struct Played {
    std::int64_t frames = 0;    // of the pattern, given to the DAC
    DeviceCounts counts;        // the DAC's own
    double ppm = 0;             // rate of the DAC's clock relative to CLOCK_MONOTONIC, minus 1
    Seconds residual{};         // mean delay of its stamps minus the shortest one
    std::string fault;          // the DAC's error; empty without a failure
    Seconds last_write_took{};  // duration of the last write, also if it failed
};

/// Plays the pattern (pattern.hpp) on the first channel, then silence of a quarter of a second. A DeviceError
/// ends it. `started` is called once, a second of frames after the beginning.
Played play_pattern(Dac& dac, int bits, std::int64_t frames, const std::function<void()>& started);

struct Heard {
    std::int64_t samples = 0;
    std::int64_t missing = 0;    // by the count on axis z
    std::int64_t wrong = 0;      // axes x and y do not fit axis z, or the count goes backwards
    std::int64_t misplaced = 0;  // the driver's tick and the count changed differently
    double rate_hz = 0;          // by the stamps of the first and the last block
    DeviceCounts counts;         // the driver's own
    std::string fault;
};

/// Reads samples of tests/vm/uhid_accelerometer.cpp for a minute at most. A DeviceError ends it.
Heard read_counted_samples(Accelerometer& accelerometer, std::int64_t samples);

struct Watched {
    std::int64_t frames = 0;
    std::int64_t span = 0;       // exposures from the first frame to the last, by the driver's ticks
    std::int64_t backwards = 0;  // ticks or stamps that did not increase
    std::int64_t unstamped = 0;  // frames without the kernel's stamp
    double rate_hz = 0;          // exposures a second by the frames' own stamps
    DeviceCounts counts;
    std::string fault;
};

/// Takes frames for `duration`. A DeviceError ends it.
Watched watch(Camera& camera, Seconds duration);

}  // namespace shaker

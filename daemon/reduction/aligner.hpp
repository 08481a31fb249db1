#pragma once
// Puts the accelerometer on the cameras' time by the motion both see, and finds frequency and shaker axis
// with it.
#include <array>
#include <string>
#include <vector>

#include "calibration/harmonic_fit.hpp"
#include "daemon/reduction/measurement.hpp"

namespace shaker {

/// The drive as measured, on master time. master = t (1 + 1e-6 ppm) - late.
struct Alignment {
    Estimate frequency;  // Hz on master time
    HarmonicFit base;    // of the base's position, m
    HarmonicFit
        acceleration;  // of the base along the shaker's axis, m/s^2; its constant is gravity and offset
    std::array<double, 3> shaker_axis{};
    std::array<HarmonicFit, 2> across;  // likewise, on the shaker axis' across_axes()
    Estimate late_s, ppm;
    double track_gain = 0;    // base acceleration by the cameras over that by the accelerometer; NaN at rest
    std::vector<double> t_s;  // accelerometer samples that the cameras cover, on master time
    std::vector<double> along_mps2;  // those samples along the shaker's axis
};

/// `m` as usable_part() returns it. Without an exact drive the frequency comes from the base's tracks (the
/// nominal one may be 1 % off) and, for short runs, from the accelerometer too, whose clock is taken to be
/// within 300 ppm (one sigma). Harmonics 1 to 3 that stand out of the noise give the lag; the axis' sign
/// comes from the shape, or (a single harmonic, odd ones only) from the smaller lag; whole periods from the
/// smaller lag. Adds a note where that was a choice or where clock, axis or camera scale disagree with what
/// was told. Throws InputError when less than two periods are in common once the lag is known.
Alignment align(const Measurement& m, std::vector<std::string>& notes);

}  // namespace shaker

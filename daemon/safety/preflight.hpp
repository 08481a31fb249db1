#pragma once
// Pre-flight check: predicted peaks of the requested motion against the limits, before a start.
#include <array>
#include <complex>
#include <string>
#include <vector>

#include "daemon/safety/limits.hpp"
#include "drivers/drive.hpp"

namespace shaker::safety {

/// The requested motion and what is needed to predict its drive.
struct PlannedMotion {
    Harmonics<Acceleration> target;  // of the base
    double frequency = 20;           // Hz
    double moving_kg = 0;            // armature, base and walker
    /// m/s^2 per V at f, 2f, ...; must not be zero for a requested harmonic.
    std::array<std::complex<double>, max_harmonics> response{};
};

/// One predicted peak and its limit, in the unit shown to the operator.
struct Demand {
    std::string quantity;  // "displacement"
    double value = 0;
    double limit = 0;  // infinite: no limit
    std::string unit;
    [[nodiscard]] bool beyond() const noexcept { return !(value <= limit); }
};

/// Peak of the displacement of a motion with these harmonics of `frequency` (Hz), without a constant part, m.
double largest_displacement(const Harmonics<Acceleration>& motion, double frequency);

/// Peaks of the requested waveform (not sums of amplitudes): acceleration (m/s^2), velocity (m/s) and
/// displacement (mm) without a constant part, force (N, moved mass times acceleration), drive (V at the
/// DAC).
std::vector<Demand> demands(const PlannedMotion& motion, const Limits& limits);

/// Throws InputError that names every peak above its limit, with both values and the gamma that would be
/// allowed.
void require_within(const std::vector<Demand>& demands, double gamma);

}  // namespace shaker::safety

#pragma once
// Before a start: the motion that is asked for, held against what shaker and sensor may do.
#include <array>
#include <complex>
#include <string>
#include <vector>

#include "daemon/control/limits.hpp"
#include "drivers/drive.hpp"

namespace shaker {

/// What a drive will ask of the bench.
struct PlannedMotion {
    Harmonics<Acceleration> target;  // of the base
    double frequency = 20;           // Hz
    double moving_kg = 0;            // all that the force moves: armature, base, walker
    /// m/s^2 a volt at f, 2f, ...; a harmonic that is asked for needs one that is not zero.
    std::array<std::complex<double>, max_harmonics> response{};
};

/// One predicted peak beside its limit, in the unit it is shown in.
struct Demand {
    std::string quantity;  // "displacement"
    double value = 0;
    double limit = 0;  // infinite: none
    std::string unit;
    [[nodiscard]] bool beyond() const noexcept { return !(value <= limit); }
};

/// Peaks of the waveform that is asked for, not sums of amplitudes: acceleration (m/s^2), velocity (m/s) and
/// displacement (mm) of the motion without a constant part, force (N, moved mass times acceleration) and
/// drive (V at the DAC).
std::vector<Demand> demands(const PlannedMotion& motion, const Limits& limits);

/// Throws InputError naming every demand that is beyond its limit, with both figures and how much smaller the
/// drive would have to be.
void require_within(const std::vector<Demand>& demands);

}  // namespace shaker

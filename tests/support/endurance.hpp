#pragma once
// Normal operation by chance: a bench that is sound, driven through one set-point after the other for as long
// as is wanted. In virtual time.
#include <cstdint>
#include <string>
#include <vector>

#include "drivers/simulated/scene.hpp"

namespace shaker::test {

/// What there was of it.
struct Endurance {
    double simulated_s = 0;
    double locked_s = 0;  // of it, with the drive at its target
    long set_points = 0;
    int runs = 0;
    std::vector<std::string> trips;  // each with the seed and the time, s: there must be none
    Endurance& operator+=(const Endurance& more);
};

/// A bench without a fault: one of three shakers with its load, a walker that is taken off and put back now
/// and then, a sensor with nominal noise, a little hum and a clock of its own. At the least rates that the
/// guard of the samples is made for: 8 kHz and 1 kHz, so that hours pass in seconds.
Scene sound_bench(std::uint64_t seed, double length_s);

/// One run of about that length on it: silence, identification, ramp; then set-points over gamma (0.25 g to
/// what shaker, sensor and DAC allow), rho, phi and 15..25 Hz, 1 to 20 s each and until
/// it is reached, 20 s at the most; ramp down.
Endurance endure(std::uint64_t seed, double length_s);

}  // namespace shaker::test

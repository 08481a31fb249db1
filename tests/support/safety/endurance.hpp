#pragma once
// Random normal operation: a sound bench is driven through random set-points in virtual time.
#include <cstdint>
#include <string>
#include <vector>

#include "drivers/simulated/scene.hpp"

namespace shaker::test {

/// Summary of the operation.
struct Endurance {
    double simulated_s = 0;
    double locked_s = 0;  // time with the drive at its target
    long set_points = 0;
    int runs = 0;
    std::vector<std::string> trips;  // each with the seed and the time, s: there must be none
    Endurance& operator+=(const Endurance& more);
};

/// A bench without faults: one of three shakers with its load, a walker that is taken off and put back at
/// times, a sensor with nominal noise, some hum and its own clock. It runs at the lowest rates that the
/// sample guard supports, 8 kHz and 1 kHz, so that hours take seconds.
simulated::Scene sound_bench(std::uint64_t seed, double length_s);

/// One run of about that length: silence, identification, ramp; then set-points over gamma (0.25 g to the
/// limit of shaker, sensor and DAC), rho, phi and 15..25 Hz, each for 1 to 20 s and until it is reached, at
/// most 20 s; ramp down.
Endurance endure(std::uint64_t seed, double length_s);

}  // namespace shaker::test

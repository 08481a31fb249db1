#pragma once
// Drives a simulated bench directly: for tests of the bench itself.
#include <vector>

#include "drivers/drive.hpp"
#include "drivers/simulated/shaker_plant.hpp"

namespace shaker::test {

/// Voltage harmonics that give the base this motion, without a walker.
inline Harmonics<Voltage> volts_for(const simulated::Scene& scene, const Drive& drive) {
    const Harmonics<Acceleration> target = harmonics(drive);
    Harmonics<Voltage> volts;
    for (int q = 1; q <= target.order(); ++q) {
        const auto [re, im] = simulated::ShakerPlant::response(scene, q * drive.frequency);
        volts.at(q) = target.at(q) / std::complex<double>{re, im};
    }
    return volts;
}

/// Samples n0, n0 + 1, ... of a drive that rises over the first ten periods.
inline std::vector<double> samples(const Harmonics<Voltage>& volts, double frequency, double rate, long n0,
                                   std::size_t count) {
    std::vector<double> out(count);
    for (std::size_t i = 0; i < count; ++i) {
        const double turns = static_cast<double>(n0 + static_cast<long>(i)) * frequency / rate;
        const double rise = turns < 10 ? 0.5 - 0.5 * std::cos(0.1 * std::numbers::pi * turns) : 1;
        out[i] = rise * value_at(volts, two_pi * turns);
    }
    return out;
}

}  // namespace shaker::test

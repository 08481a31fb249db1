#pragma once
// Scenes of a shaker reduced to the law under test.
#include <cmath>

#include "drivers/simulated/shaker_plant.hpp"

namespace shaker::test {

/// A mass of 1 kg that the DAC pushes with 1 N per V: no spring, no damping, no AC coupling, and a walker
/// without mass that never slips.
inline simulated::Scene one_newton_a_volt() {
    simulated::Scene s = simulated::paper_scene();
    s.walker.mass_kg = 1e-12;
    s.walker.mu_k = s.walker.mu_s = 1e6;
    s.dac_full_scale_v = 100;
    simulated::ShakerTruth& p = s.shaker;
    p.drive = simulated::DriveKind::current;
    p.moving_mass_kg = 0.4;
    p.base_mass_kg = 0.6;
    p.stiffness_npm = 0;
    p.damping_nspm = 0;
    p.force_factor_npa = 1;
    p.amplifier_gain = 1;
    p.amplifier_limit_a = 1000;
    p.high_pass_hz = {0, 0};
    return s;
}

/// Accelerates a resting base of one_newton_a_volt() to velocity v (m/s) in one millisecond, minus the effect
/// of sliding friction (`friction`, N).
inline void throw_base(simulated::ShakerPlant& plant, const simulated::Scene& scene, double v,
                       double friction = 0) {
    const long n = std::lround(1e-3 * scene.dac_rate_hz);
    for (long i = 0; i < n; ++i) plant.step(std::copysign(friction, v) + v / 1e-3);
    plant.step(0);
}

}  // namespace shaker::test

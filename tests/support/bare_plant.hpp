#pragma once
// Scenes of a shaker stripped to the law that a test is about.
#include <cmath>

#include "drivers/simulated/shaker_plant.hpp"

namespace shaker::test {

/// A mass of 1 kg that the DAC pushes with 1 N a volt: no spring, no damping, no AC coupling, and a walker
/// that weighs nothing and never slips.
inline Scene one_newton_a_volt() {
    Scene s = paper_scene();
    s.walker.mass_kg = 1e-12;
    s.walker.mu_k = s.walker.mu_s = 1e6;
    s.dac_full_scale_v = 100;
    ShakerTruth& p = s.shaker;
    p.drive = DriveKind::current;
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

/// Pushes a resting base of one_newton_a_volt() to velocity v (m/s) in one millisecond, minus what a slide's
/// friction of `friction` newtons takes.
inline void throw_base(ShakerPlant& plant, const Scene& scene, double v, double friction = 0) {
    const long n = std::lround(1e-3 * scene.dac_rate_hz);
    for (long i = 0; i < n; ++i) plant.step(std::copysign(friction, v) + v / 1e-3);
    plant.step(0);
}

}  // namespace shaker::test

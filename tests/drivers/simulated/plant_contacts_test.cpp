#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/support/control/bare_plant.hpp"
#include "tests/support/control/bench_drive.hpp"

namespace shaker::simulated {
namespace {

TEST(PlantContactsTest, BaseRestsBelowStaticFriction) {
    Scene s = paper_scene();
    s.shaker.static_friction_n = 5;
    s.shaker.kinetic_friction_n = 4;
    ShakerPlant plant{s};
    double current = 0;
    for (long i = 0; i < 48000; ++i) {  // at most 10 V x 0.12 / 2 ohm x 6.78 N/A = 4.1 N
        plant.step(0.12 * std::sin(two_pi * 20 * static_cast<double>(i) / s.dac_rate_hz));
        const PlantState& p = plant.state();
        ASSERT_EQ(p.x, 0);
        ASSERT_EQ(p.v, 0);
        ASSERT_EQ(p.a, 0);
        ASSERT_EQ(p.walker_x, 1e-3 * s.walker.start_mm);
        current = std::max(current, std::abs(p.current));
    }
    EXPECT_EQ(plant.events(), 0);
    EXPECT_GT(current, 0.5);  // the coil still has its current
}

TEST(PlantContactsTest, BaseBreaksAwayAtStaticFriction) {
    Scene s = test::one_newton_a_volt();
    s.shaker.static_friction_n = 3;
    s.shaker.kinetic_friction_n = 2;
    ShakerPlant plant{s};
    for (long i = 0; i < 3000; ++i) plant.step(1e-3 * static_cast<double>(i));
    EXPECT_TRUE(plant.state().held);
    plant.step(3.001);
    EXPECT_FALSE(plant.state().held);
    EXPECT_NEAR(plant.state().v, 1.001 / s.dac_rate_hz, 1e-15);  // 3.001 N - 2 N on 1 kg for a sample
    for (int i = 0; i < 10; ++i) plant.step(2);
    EXPECT_NEAR(plant.state().v, 1.001 / s.dac_rate_hz, 1e-15);  // drive and friction in balance
    plant.step(0);  // 2 N would stop 1.001 / 48000 m/s in half a sample
    EXPECT_EQ(plant.state().v, 0);
    EXPECT_TRUE(plant.state().held);
}

TEST(PlantContactsTest, DryFrictionDampsHalfSwingsEqually) {
    // Each half swing is shorter by 2 F / k; the base comes to rest at the first turning point with k |x| <
    // F.
    Scene s = test::one_newton_a_volt();
    const double k = s.shaker.stiffness_npm = 1e4, friction = 0.4;
    s.shaker.static_friction_n = s.shaker.kinetic_friction_n = friction;
    ShakerPlant plant{s};
    for (int i = 0; i < 60; ++i) plant.step(50);
    plant.step(0);
    // Turning point that this motion runs to: (k x + F)^2 = (k x1 + F)^2 + k M v^2.
    const PlantState start = plant.state();
    double turn = (std::hypot(k * start.x + friction, std::sqrt(k) * start.v) - friction) / k;
    int swings = 0;
    while (k * std::abs(turn) > friction) {
        turn = -std::copysign(std::abs(turn) - 2 * friction / k, turn);
        ++swings;
    }
    for (long i = 0; i < 48000; ++i) plant.step(0);
    EXPECT_GT(swings, 5);
    EXPECT_TRUE(plant.state().held);
    EXPECT_NEAR(plant.state().x, turn, 1e-15);
}

TEST(PlantContactsTest, WalkerSlidesDownHeldBase) {
    Scene s = paper_scene();
    s.tilt_deg = 10;  // tan 10 deg > mu
    s.shaker.static_friction_n = s.shaker.kinetic_friction_n = 1;
    ShakerPlant plant{s};
    for (int i = 0; i < 4800; ++i) plant.step(0);
    const double angle = 10 * std::numbers::pi / 180;
    const double a = s.gravity * (std::sin(angle) - s.walker.mu_k * std::cos(angle));
    EXPECT_EQ(plant.state().x, 0);
    EXPECT_EQ(plant.state().slip, 1);
    EXPECT_NEAR(plant.state().walker_v, 0.1 * a, 1e-13);
    EXPECT_NEAR(plant.state().walker_x, -0.04 + 0.005 * a, 1e-14);

    s.shaker.static_friction_n = s.shaker.kinetic_friction_n =
        0.06;  // its drag is 0.065 N: it takes the base
    ShakerPlant loose{s};
    for (int i = 0; i < 4800; ++i) loose.step(0);
    EXPECT_GT(loose.state().x, 0);
}

TEST(PlantContactsTest, DetectsSlipBetweenTwoSamples) {
    // A base that rings: the peak of its acceleration is above the walker's grip, no sample of it is.
    Scene s = test::one_newton_a_volt();
    const double k = s.shaker.stiffness_npm = 1e4;
    ShakerPlant riding{s};
    riding.step(1e4);
    riding.step(0);
    const PlantState& ring = riding.state();
    const double peak = std::sqrt(k) * std::hypot(std::sqrt(k) * ring.x, ring.v);
    long samples = 2;
    double sampled = 0;
    for (; ring.v > 0; ++samples) {
        riding.step(0);
        sampled = std::max(sampled, std::abs(ring.a));
    }
    ASSERT_LT(sampled, peak * (1 - 1e-9));
    s.walker.mu_s = 0.5 * (peak + sampled) / s.gravity;
    s.walker.mu_k = 0.5 * s.walker.mu_s;
    ShakerPlant plant{s};
    plant.step(1e4);
    for (long i = 1; i < samples; ++i) plant.step(0);
    EXPECT_EQ(plant.state().slip, 1);
}

TEST(PlantContactsTest, EndStopReturnsUndampedEnergy) {
    // Against a spring and damper that push and never pull, a mass without other forces comes back with
    // exp(-zeta phi / root) of its velocity, root = sqrt(1 - zeta^2), phi = atan2(2 zeta root, 2 zeta^2 - 1).
    for (const double zeta : {0.0, 0.02, 0.3, 0.8})
        for (const double side : {1.0, -1.0}) {
            Scene s = test::one_newton_a_volt();
            ShakerTruth& p = s.shaker;
            p.stop_travel_mm = 2;
            p.stop_stiffness_npm = 4e5;
            const double w = std::sqrt(p.stop_stiffness_npm), v = 0.2;  // 1 kg
            p.stop_damping_nspm = 2 * zeta * w;
            ShakerPlant plant{s};
            test::throw_base(plant, s, side * v);
            double furthest = 0;
            for (long i = 0; i < 960; ++i) {
                plant.step(0);
                furthest = std::max(furthest, side * plant.state().x);
            }
            const double root = std::sqrt(1 - zeta * zeta);
            const double phi = std::atan2(2 * zeta * root, 2 * zeta * zeta - 1);
            EXPECT_NEAR(plant.state().v, -side * v * std::exp(-zeta * phi / root), 1e-12) << "zeta " << zeta;
            EXPECT_EQ(plant.state().stop, 0);
            EXPECT_EQ(plant.events(), 2);
            const double deepest = v / w * std::exp(-zeta / root * std::acos(zeta));
            EXPECT_LE(furthest, 2e-3 + deepest * (1 + 1e-12));
            EXPECT_GT(furthest, 2e-3 + 0.99 * deepest);
        }
}

TEST(PlantContactsTest, StopsNeverAddEnergy) {
    // Hammering between its stops under drive, in every mode of walker and slide: the energy of the base
    // never rises by more than the coil's work.
    Scene s = test::one_newton_a_volt();
    ShakerTruth& p = s.shaker;
    s.dac_rate_hz = 192e3;
    s.walker.mass_kg = 0.3;
    s.walker.mu_k = s.walker.mu_s = 0.113;
    p.stop_travel_mm = 0.3;
    p.stop_stiffness_npm = 3e5;
    p.stop_damping_nspm = 30;
    p.static_friction_n = p.kinetic_friction_n = 0.5;
    ShakerPlant plant{s};
    double work = 0, most = 0;
    long touches = 0;
    for (long i = 0; i < 192000; ++i) {
        const PlantState before = plant.state();
        const double force = 8 * std::sin(two_pi * 23 * static_cast<double>(i) / s.dac_rate_hz);
        plant.step(force);
        const PlantState& now = plant.state();
        work += force * (now.x - before.x);  // exact: the force is held
        const double kinetic = 0.5 * now.v * now.v + 0.15 * now.walker_v * now.walker_v;
        most = std::max(most, kinetic - work);
        touches += now.stop != 0 && before.stop == 0 ? 1 : 0;
        const double depth = std::abs(now.x) - 0.3e-3;
        EXPECT_LE(0.5 * p.stop_stiffness_npm * depth * std::max(depth, 0.0), work + 1e-9);
    }
    EXPECT_GT(touches, 30);
    EXPECT_LT(most, 1e-12);
    EXPECT_GT(work, 0.01);
}

TEST(PlantContactsTest, CycleConservesEnergy) {
    // What the amplifier gives is what coil, damping, slide and walker's friction turn to heat, plus what is
    // stored. Integrals by the trapezoid rule at 384 kHz.
    Scene s = paper_scene();
    s.dac_rate_hz = 384e3;
    ShakerTruth& p = s.shaker;
    p.cubic_stiffness_npm3 = 4e10;
    p.force_factor_falloff_pm2 = 2e5;
    p.static_friction_n = 0.5;
    p.kinetic_friction_n = 0.4;
    ShakerPlant plant{s};
    const double h = 1 / s.dac_rate_hz, mass = p.moving_mass_kg + p.base_mass_kg, m = s.walker.mass_kg;
    const auto stored = [&](const PlantState& a) {
        return 0.5 * (p.inductance_h * a.current * a.current + mass * a.v * a.v +
                      p.stiffness_npm * a.x * a.x + m * a.walker_v * a.walker_v) +
               0.25 * p.cubic_stiffness_npm3 * std::pow(a.x, 4);
    };
    const auto heat = [&](const PlantState& a) {
        return p.resistance_ohm * a.current * a.current + p.damping_nspm * a.v * a.v +
               p.kinetic_friction_n * std::abs(a.v) +
               s.walker.mu_k * m * s.gravity * std::abs(a.walker_v - a.v);
    };
    const double before = stored(plant.state());
    double given = 0, lost = 0;
    for (long i = 0; i < 96000; ++i) {
        const PlantState from = plant.state();
        plant.step(0.5 * std::sin(two_pi * 20 * static_cast<double>(i) * h));
        const PlantState& to = plant.state();
        given += h * plant.amplifier_output() * 0.5 * (from.current + to.current);
        lost += h * 0.5 * (heat(from) + heat(to));
    }
    EXPECT_GT(given, 0.1);
    EXPECT_NEAR((given - lost - (stored(plant.state()) - before)) / given, 0, 1e-6);
}

TEST(PlantContactsTest, RemovedWalkerHasNoReaction) {
    const Scene s = paper_scene();
    Scene bare = s;
    bare.walker.mass_kg = 1e-12;
    ShakerPlant plant{s}, alone{bare};
    const auto volts = test::samples(test::volts_for(s, {.gamma = 9.8}), 20, 48000, 0, 240000);
    double place = 0;
    for (std::size_t i = 0; i < volts.size(); ++i) {
        if (i == 48000) {
            plant.set_walker(false);
            place = plant.state().walker_x;
        }
        if (i == 192000) {
            EXPECT_NEAR(plant.state().x, alone.state().x, 1e-9);  // its memory has died away
            EXPECT_EQ(plant.state().walker_x, place);
            plant.set_walker(true);
        }
        plant.step(volts[i]);
        alone.step(volts[i]);
        if (i == 191999) {
            EXPECT_FALSE(plant.has_walker());
        }
        if (i == 192000) {
            // One sample after: it rides along, or slips with what friction gives in a sample.
            EXPECT_LT(std::abs(plant.state().walker_v - plant.state().v), 20.0 / 48000);
        }
    }
    EXPECT_GT(std::abs(plant.state().x - alone.state().x), 1e-7);
}

}  // namespace
}  // namespace shaker::simulated

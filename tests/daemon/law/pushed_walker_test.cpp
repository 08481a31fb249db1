#include "daemon/law/pushed_walker.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "daemon/law/sensitivity.hpp"
#include "drivers/simulated/scene.hpp"
#include "drivers/simulated/shaker_plant.hpp"
#include "drivers/walker/steady_state.hpp"
#include "tests/support/law/synthetic_points.hpp"

namespace shaker::law {
namespace {

using std::numbers::pi;
using test::drive_at;

constexpr Coulomb paper_bench{.mu = 0.113, .push = 0.06 / 0.557};

double drift(const Drive& drive, const Coulomb& law) {
    return pushed_cycle(harmonics(drive), drive.frequency, law).v_D;
}

TEST(PushedWalkerTest, WithoutPushIsTheExactWalker) {
    for (const double phi : {0.0, 1.57, 2.36, 4.0})
        for (const double gamma : {0.2, 0.5, 1.0, 3.0, 20.0}) {
            const Drive d = drive_at(gamma, phi);
            walker::WalkerSetting s;
            s.base = harmonics(d);
            s.tilt = 2e-3;
            s.friction = {0.113, 0.113};
            EXPECT_NEAR(drift(d, {.mu = 0.113, .tilt = 2e-3}), walker::settle(s).v_D,
                        1e-10 * d.gamma / (two_pi * d.frequency))
                << gamma << " g, " << phi;
        }
}

TEST(PushedWalkerTest, StartChangesNothingButTheCost) {
    const Drive d = drive_at(1, 2.2);
    const PushedCycle cold = pushed_cycle(harmonics(d), 20, paper_bench);
    Coulomb near = paper_bench;
    near.mu *= 1.001;
    const PushedCycle from = pushed_cycle(harmonics(d), 20, near);
    EXPECT_NEAR(pushed_cycle(harmonics(d), 20, paper_bench, &from).v_D, cold.v_D, 1e-10);
    EXPECT_LT(cold.settles, 12);
}

TEST(PushedWalkerTest, HalfATurnOfPhiFlipsTheDriftOnALevelBase) {
    for (const double phi : {0.0, 1.0, 2.2})
        EXPECT_NEAR(drift(drive_at(1, phi + pi), paper_bench), -drift(drive_at(1, phi), paper_bench), 1e-9);
    Coulomb tilted = paper_bench;
    tilted.tilt = 1e-3;
    EXPECT_GT(std::abs(drift(drive_at(1, pi), tilted) + drift(drive_at(1, 0), tilted)), 1e-4);
}

TEST(PushedWalkerTest, DriftScalesWithPeriodAndAcceleration) {
    const double v = drift(drive_at(1, 2.2), paper_bench);
    Drive slow = drive_at(1, 2.2), strong = drive_at(2, 2.2);
    slow.frequency = 10;
    EXPECT_NEAR(drift(slow, paper_bench), 2 * v, 1e-9);
    Coulomb rough = paper_bench;
    rough.mu *= 2;
    EXPECT_NEAR(drift(strong, rough), 2 * v, 1e-9);
}

TEST(PushedWalkerTest, RestWhereFrictionHolds) {
    const PushedCycle cycle = pushed_cycle(harmonics(drive_at(0.1, 0)), 20, paper_bench);
    EXPECT_NEAR(cycle.v_D, 0, 1e-12);
    EXPECT_EQ(cycle.segments.size(), 1U);
}

TEST(PushedWalkerTest, SegmentHarmonicsAreThoseOfTheSignal) {
    const PushedCycle cycle = pushed_cycle(harmonics(drive_at(0.5, 0)), 20, paper_bench);
    const std::array<double, 2> slip{1.3, -0.8};
    constexpr int n = 200000;
    std::complex<double> sum = 0;
    for (int i = 0; i < n; ++i) {
        const double at = two_pi * (i + 0.5) / n;
        for (const Segment& s : cycle.segments)
            for (const double theta : {at, at + two_pi})
                if (theta >= s.from && theta < s.to)
                    sum +=
                        std::complex<double>{0, 2.0 / n} * std::polar(1.0, -3 * at) *
                        (s.contact == walker::Contact::stick ? value_at(cycle.free, at)
                                                             : slip[s.contact == walker::Contact::forward]);
    }
    EXPECT_LT(std::abs(sum - segment_harmonics(cycle.segments, slip, cycle.free, 40)[2]), 1e-4);
    EXPECT_LT(std::abs(sum - segment_harmonics(cycle.segments, slip, cycle.free)[2]), 1e-4);
}

// Base harmonics 1 to 16 and v_D of the simulated shaker with its walker, from one settled period.
struct Bench {
    Harmonics<Acceleration> base{};
    double v_D = 0;
};
Bench on_the_bench(double gamma_in_g, double phi) {
    const simulated::Scene scene = simulated::paper_scene();
    simulated::ShakerPlant plant{scene};
    constexpr int n = 2400;
    const auto volts_for = [&](std::complex<double> a, double f) {
        const auto r = simulated::ShakerPlant::response(scene, f);
        return a / std::complex<double>{r[0], r[1]};
    };
    const auto v1 = volts_for(gamma_in_g * 4.9, 20), v2 = volts_for(std::polar(gamma_in_g * 4.9, phi), 40);
    const auto step = [&](int k) {
        const double at = two_pi * (k + 0.5) / n;
        plant.step((v1 * std::polar(1.0, at) + v2 * std::polar(1.0, 2 * at)).imag());
    };
    for (int k = 0; k < 200 * n; ++k) step(k % n);
    const double from = plant.state().walker_x;
    Bench out;
    for (int k = 0; k < n; ++k) {
        step(k);
        for (int q = 1; q <= max_harmonics; ++q)  // from the velocity, which has no jumps
            out.base.at(q) += std::complex<double>{0, 2.0 / n} * std::complex<double>{0, q * two_pi * 20} *
                              plant.state().v * std::polar(1.0, -q * two_pi * (k + 1) / n);
    }
    out.v_D = (plant.state().walker_x - from) * 20;
    return out;
}

// The push above harmonic 16 is -0.027 mm/s of v_D at 1 g, phi = 0. The law is within the effect of the
// base's spring and of the sampling.
TEST(PushedWalkerTest, AgreesWithTheSimulatedShaker) {
    Coulomb law = paper_bench;
    law.drag = 0.0685;
    for (const auto& [gamma, phi] : {std::pair{1.0, 0.0}, {1.0, 2.2}, {2.0, 1.95}, {0.5, 2.7}}) {
        const Bench bench = on_the_bench(gamma, phi);
        const PushedCycle cycle = pushed_cycle(bench.base, 20, law);
        const double v_D = cycle.v_D + law.drag * Sensitivity{cycle, 20, law}.by_drag();
        EXPECT_NEAR(v_D, bench.v_D, 2e-7) << gamma << " g, " << phi;
    }
    const Bench bench = on_the_bench(1, 0);
    EXPECT_GT(pushed_cycle(bench.base, 20, {.mu = 0.113}).v_D - bench.v_D, 2e-5);
}

}  // namespace
}  // namespace shaker::law

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "tests/support/control/bare_plant.hpp"
#include "tests/support/control/bench_drive.hpp"

namespace shaker::simulated {
namespace {

// Instants of x = 0 upwards, found by the cubic through positions and velocities.
std::vector<double> upward_zeros(ShakerPlant& plant, double h, long samples) {
    std::vector<double> zeros;
    for (long i = 0; i < samples; ++i) {
        const PlantState a = plant.state();
        plant.step(0);
        const PlantState b = plant.state();
        if (!(a.x < 0 && b.x >= 0)) continue;
        double u = a.x / (a.x - b.x);
        for (int k = 0; k < 5; ++k) {  // Newton
            const double s = 1 - u;
            const double x =
                a.x * s * s * (1 + 2 * u) + b.x * u * u * (3 - 2 * u) + h * u * s * (a.v * s - b.v * u);
            u -= x / (h * std::lerp(a.v, b.v, u));
        }
        zeros.push_back(h * (static_cast<double>(i) + u));
    }
    return zeros;
}

TEST(PlantNonlinearTest, CubicSpringPeriodIsEllipticIntegral) {
    for (const double share : {0.0, 0.4, 3.0}) {  // k3 A^2 / k
        Scene s = test::one_newton_a_volt();
        const double k = 1e4, A = 0.5e-3, k3 = share * k / (A * A);
        s.shaker.stiffness_npm = k;
        s.shaker.cubic_stiffness_npm3 = k3;
        ShakerPlant plant{s};
        // One sample's push; from then on its energy stays.
        const double energy = 0.5 * k * A * A + 0.25 * k3 * A * A * A * A;
        plant.step(std::sqrt(2 * energy) * s.dac_rate_hz);
        plant.step(0);
        const auto energy_now = [&] {
            const PlantState& p = plant.state();
            return 0.5 * p.v * p.v + 0.5 * k * p.x * p.x + 0.25 * k3 * std::pow(p.x, 4);
        };
        const double before = energy_now();
        const auto zeros = upward_zeros(plant, 1 / s.dac_rate_hz, 48000);
        EXPECT_NEAR(energy_now(), before, 1e-11 * before);  // 48000 roundings
        // The amplitude that this energy has, from k A^2 / 2 + k3 A^4 / 4.
        const double square = share == 0 ? 2 * before / k : (std::sqrt(k * k + 4 * k3 * before) - k) / k3;
        const double stiff = k + k3 * square;
        const double period = 4 * std::comp_ellint_1(std::sqrt(0.5 * k3 * square / stiff)) / std::sqrt(stiff);
        ASSERT_GT(zeros.size(), 10U);
        const double measured = (zeros.back() - zeros.front()) / static_cast<double>(zeros.size() - 1);
        EXPECT_NEAR(measured / period, 1, 1e-9) << "k3 A^2 / k = " << share;
    }
}

TEST(PlantNonlinearTest, TheCoilsFluxIsTheIntegralOfTheForceFactor) {
    // L di/dt = V - R i - Bl (1 - b x^2) dx/dt, integrated: L i + Bl (x - b x^3 / 3) = integral of V - R i.
    Scene s = test::one_newton_a_volt();
    s.dac_rate_hz = 384e3;
    ShakerTruth& p = s.shaker;
    p.drive = DriveKind::voltage;
    p.amplifier_limit_v = 1000;
    p.stiffness_npm = 1e4;
    p.resistance_ohm = 0.01;
    p.inductance_h = 2e-3;
    p.force_factor_npa = 7;
    const double b = p.force_factor_falloff_pm2 = 5e4;
    ShakerPlant plant{s};
    double integral = 0, largest = 0, furthest = 0, before = 0;
    for (long i = 0; i < 192000; ++i) {
        const double t = static_cast<double>(i) / s.dac_rate_hz, volts = 0.5 * std::sin(two_pi * 20 * t);
        plant.step(volts);
        const PlantState& now = plant.state();
        integral += (volts - p.resistance_ohm * 0.5 * (before + now.current)) / s.dac_rate_hz;
        before = now.current;
        const double flux =
            p.inductance_h * now.current + p.force_factor_npa * (now.x - b * std::pow(now.x, 3) / 3);
        largest = std::max(largest, std::abs(flux - integral));
        furthest = std::max(furthest, std::abs(now.x));
    }
    EXPECT_GT(b * furthest * furthest, 0.01);                  // the field does fade
    EXPECT_LT(largest, 1e-9 * p.force_factor_npa * furthest);  // the trapezoid of R i: h^2 w^2 / 12 of it
}

Scene everything() {
    Scene s = paper_scene();
    s.tilt_deg = 0.5;
    s.walker.mu_s = 0.13;
    s.walker.mass_kg = 0.03;
    ShakerTruth& p = s.shaker;
    p.high_pass_hz = {0, 0};
    p.cubic_stiffness_npm3 = 4e10;
    p.force_factor_falloff_pm2 = 2e5;
    p.static_friction_n = 2.5;
    p.kinetic_friction_n = 2;
    p.stop_travel_mm = 0.35;
    p.stop_stiffness_npm = 2e5;
    return s;
}

TEST(PlantNonlinearTest, HalfTheStepGivesTheSameMotion) {
    for (const DriveKind drive : {DriveKind::voltage, DriveKind::current}) {
        Scene whole = everything();
        whole.shaker.drive = drive;
        whole.shaker.amplifier_gain = drive == DriveKind::voltage ? 10 : 3;
        Scene half = whole;
        half.dac_rate_hz = 2 * whole.dac_rate_hz;
        ShakerPlant one{whole}, two{half};
        double apart = 0;
        std::array<bool, 5> seen{};
        for (long i = 0; i < 24000; ++i) {
            const double volts = std::sin(two_pi * 20 * static_cast<double>(i) / whole.dac_rate_hz) *
                                 std::min(1.0, static_cast<double>(i) / 9600);
            one.step(volts);
            two.step(volts);
            two.step(volts);
            const PlantState &a = one.state(), &b = two.state();
            apart = std::max(
                {apart, std::abs(a.x - b.x), std::abs(a.v - b.v) / 125, std::abs(a.walker_x - b.walker_x)});
            seen[0] |= a.held && a.slip == 0;
            seen[1] |= a.held && a.slip != 0;
            seen[2] |= !a.held && a.slip == 0;
            seen[3] |= !a.held && a.slip != 0 && a.stop == 0;
            seen[4] |= a.stop != 0;
        }
        EXPECT_LT(apart, 1e-13) << "m, on 0.4 mm";  // each contact's change is located to 1e-16 s
        for (std::size_t k = 0; k < seen.size(); ++k) EXPECT_TRUE(seen[k]) << k;
    }
}

TEST(PlantNonlinearTest, HalfTheStepGivesTheSameMotionOfAnyShaker) {
    // Without end stops, which can make motion chaotic: rounding would grow.
    for (unsigned seed = 1; seed <= 40; ++seed) {
        std::mt19937_64 random{seed};
        const auto between = [&](double a, double b) {
            return a * std::pow(b / a, std::generate_canonical<double, 53>(random));
        };
        const auto maybe = [&](double x) { return (random() & 1024U) != 0 ? x : 0; };
        Scene s = paper_scene();
        ShakerTruth& p = s.shaker;
        s.tilt_deg = maybe(between(0.1, 12));
        s.walker.mass_kg = between(1e-6, 1);
        s.walker.mu_k = maybe(between(0.01, 0.5));
        s.walker.mu_s = s.walker.mu_k * (1 + maybe(between(0.01, 0.5)));
        p.drive = maybe(1) != 0 ? DriveKind::current : DriveKind::voltage;
        p.moving_mass_kg = between(0.05, 1);
        p.stiffness_npm = between(100, 1e5);
        p.cubic_stiffness_npm3 = maybe(between(1e8, 1e11));
        p.force_factor_falloff_pm2 = maybe(between(100, 5e3));
        p.damping_nspm = between(1, 100);
        p.kinetic_friction_n = maybe(between(0.01, 10));
        p.static_friction_n = p.kinetic_friction_n * (1 + maybe(between(0.01, 0.5)));
        p.force_factor_npa = between(2, 40);
        p.amplifier_gain = between(0.5, 20);
        p.high_pass_hz = {0, 0};
        Scene half = s;
        half.dac_rate_hz = 2 * s.dac_rate_hz;
        ShakerPlant one{s}, two{half};
        double apart = 0, furthest = 1e-3;
        for (long i = 0; i < 4800; ++i) {
            const double volts = std::sin(two_pi * 40 * static_cast<double>(i) / s.dac_rate_hz);
            one.step(volts);
            two.step(volts);
            two.step(volts);
            furthest = std::max(furthest, std::abs(one.state().x));
            apart = std::max({apart, std::abs(one.state().x - two.state().x),
                              std::abs(one.state().walker_x - two.state().walker_x)});
        }
        EXPECT_LT(apart, 1e-11 * furthest) << "seed " << seed;
        EXPECT_LT(furthest, 0.1) << "seed " << seed;
    }
}

// The model written down once more and stepped in the simplest way: semi-implicit Euler, friction as an
// impulse that is at most what it takes to stop. First order in the step.
struct Stepper {
    const Scene& s;
    double h;
    double i = 0, x = 0, v = 0, walker_v = 0, walker_x = 0;  // SI

    void step(double volts) {
        const ShakerTruth& p = s.shaker;
        const double mass = p.moving_mass_kg + p.base_mass_kg, m = s.walker.mass_kg;
        const double field = p.force_factor_npa * (1 - p.force_factor_falloff_pm2 * x * x);
        const double out = p.amplifier_gain * volts;
        if (p.drive == DriveKind::current)
            i = out;
        else
            i = (p.inductance_h * i + h * (out - field * v)) / (p.inductance_h + h * p.resistance_ohm);
        double force =
            field * i - p.stiffness_npm * x - p.cubic_stiffness_npm3 * x * x * x - p.damping_nspm * v;
        const double side = x < 0 ? -1 : 1, depth = side * x - 1e-3 * p.stop_travel_mm;
        if (p.stop_travel_mm > 0 && depth > 0)
            force -= side * std::max(0.0, p.stop_stiffness_npm * depth + p.stop_damping_nspm * side * v);
        v += h * force / mass;
        walker_v += h * s.gravity * std::sin(s.tilt_deg * std::numbers::pi / 180);
        // Walker and slide take turns until both hold.
        double walker_done = 0, slide_done = 0;
        const double grip = s.walker.mu_k * m * s.gravity * std::cos(s.tilt_deg * std::numbers::pi / 180) * h;
        const double slide = p.kinetic_friction_n * h, shared = 1 / (1 / m + 1 / mass);
        for (int k = 0; k < 20; ++k) {
            const double want = std::clamp(walker_done + (walker_v - v) * shared, -grip, grip) - walker_done;
            walker_done += want;
            walker_v -= want / m;
            v += want / mass;
            const double hold = std::clamp(slide_done - v * mass, -slide, slide) - slide_done;
            slide_done += hold;
            v += hold / mass;
        }
        x += h * v;
        walker_x += h * walker_v;
    }
};

TEST(PlantNonlinearTest, MatchesIndependentTimeStepper) {
    Scene s = everything();
    s.walker.start_mm = 0;
    s.walker.mu_s = s.walker.mu_k;
    s.shaker.static_friction_n = s.shaker.kinetic_friction_n;
    const auto apart = [&](int fine) {  // m, the most over 0.1 s
        ShakerPlant plant{s};
        Stepper euler{s, 1 / (fine * s.dac_rate_hz)};
        double most = 0;
        for (long i = 0; i < 4800; ++i) {
            const double volts = std::sin(two_pi * 20 * static_cast<double>(i) / s.dac_rate_hz);
            plant.step(volts);
            for (int k = 0; k < fine; ++k) euler.step(volts);
            most = std::max({most, std::abs(plant.state().x - euler.x),
                             std::abs(plant.state().walker_x - euler.walker_x)});
        }
        return most;
    };
    // The stepper comes to the plant as its step shrinks: what moves by millimetres, to 0.1 um.
    const double coarse = apart(8), fine = apart(128);
    EXPECT_LT(fine, 1e-7);
    EXPECT_LT(fine, 0.3 * coarse);
}

TEST(PlantNonlinearTest, OddNonlinearityGivesNoEvenHarmonics) {
    Scene s = everything();
    s.tilt_deg = 0;
    s.shaker.high_pass_hz = {2, 3};
    ShakerPlant plant{s};
    constexpr long period = 2400, periods = 120;
    std::array<std::complex<double>, 7> sums{};
    for (long i = 0; i < periods * period; ++i) {
        plant.step(std::sin(two_pi * static_cast<double>(i) / period) *
                   std::min(1.0, static_cast<double>(i) / (20 * period)));
        if (i < (periods - 1) * period) continue;
        for (std::size_t q = 1; q < sums.size(); ++q)
            sums[q] += plant.state().a * std::polar(2.0 / period, -two_pi * static_cast<double>(q) *
                                                                      static_cast<double>(i) / period);
    }
    EXPECT_GT(std::abs(sums[3]), 1e-2 * std::abs(sums[1]));
    for (const std::size_t q : {2U, 4U, 6U}) EXPECT_LT(std::abs(sums[q]), 1e-6 * std::abs(sums[1])) << q;
}

}  // namespace
}  // namespace shaker::simulated

// Published results of another simulated shaker, reproduced on ours.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/support/control/bare_plant.hpp"
#include "tests/support/control/bench_drive.hpp"

namespace shaker::simulated {
namespace {

constexpr long period = 2400;  // samples at 20 Hz and 48 kHz

Scene with(const std::string& shaker) { return parse_scene("[shaker]\n" + shaker, "test"); }

double db(double ratio) { return 20 * std::log10(ratio); }

// Complex amplitude of harmonic q of one period, relative to sin.
std::complex<double> harmonic(const std::vector<PlantState>& states, double PlantState::*part, int q) {
    std::complex<double> sum = 0;
    for (std::size_t i = 0; i < states.size(); ++i)
        sum += states[i].*part * std::polar(2.0 / period, -two_pi * q * static_cast<double>(i) / period);
    return std::complex<double>{0, 1} * sum;
}

// The last of `periods` under a voltage that would give the base the motion `drive` without a walker.
std::vector<PlantState> last_period(const Scene& scene, const Drive& drive, long periods) {
    const auto volts = test::samples(test::volts_for(scene, drive), 20, scene.dac_rate_hz, 0,
                                     static_cast<std::size_t>(periods * period));
    ShakerPlant plant{scene};
    std::vector<PlantState> states;
    for (std::size_t i = 0; i < volts.size(); ++i) {
        if (i + period >= volts.size()) states.push_back(plant.state());
        plant.step(volts[i]);
    }
    return states;
}

TEST(PlantTableTest, WalkersReactionMatchesPublishedTable) {
    // LDS V203, voltage drive, 20 Hz, 1 g, open loop: complex error of each harmonic, dB of gamma; `tail` is
    // the rms of harmonics 9 to 40. The published integrator is semi-implicit Euler at the same 48 kHz; its
    // -44 dB in harmonic 7 of 120 g is left out: ours stays at -48.9 dB with a four times finer step too. The
    // -150 dB of an even harmonic are compared with the images of a held sample, -95 dB.
    struct Row {
        double walker_kg, base_kg;
        double k1, k2, k3, k5, k7, tail;
    };
    for (const Row& row :
         {Row{0.03, 0.33, -33, -77, -47, -51, -55, -53.6}, Row{0.06, 0.33, -27, -56, -41, -45, -50, -47.2},
          Row{0.12, 0.33, -21, -42, -34, -38, NAN, -41.0},
          Row{0.06, 1.00, -40, -150, -51, -55, -58, -57.3}}) {
        Scene s = with("model = \"LDS V203\"");
        s.gravity = 9.81;
        s.walker.mass_kg = row.walker_kg;
        s.shaker.base_mass_kg = row.base_kg - s.shaker.moving_mass_kg;
        const Drive drive{.gamma = 9.81};
        const auto last = last_period(s, drive, 150);
        const auto error = [&](int q) {
            std::complex<double> want = 0;
            if (q <= 2) want = harmonics(drive).at(q) * std::polar(1.0, -q * std::numbers::pi / period);
            return std::abs(harmonic(last, &PlantState::a, q) - want) / drive.gamma;
        };
        double tail = 0;
        for (int q = 9; q <= 40; ++q) tail += 0.5 * error(q) * error(q);
        EXPECT_NEAR(db(error(1)), row.k1, 1.5) << row.walker_kg << " kg on " << row.base_kg;
        EXPECT_NEAR(std::max(db(error(2)), -95.0), std::max(row.k2, -95.0), 1.5)
            << row.walker_kg << " kg on " << row.base_kg;
        EXPECT_NEAR(db(error(3)), row.k3, 1.5) << row.walker_kg << " kg on " << row.base_kg;
        EXPECT_NEAR(db(error(5)), row.k5, 1.5) << row.walker_kg << " kg on " << row.base_kg;
        if (!std::isnan(row.k7)) {
            EXPECT_NEAR(db(error(7)), row.k7, 1.5) << row.walker_kg << " kg on " << row.base_kg;
        }
        EXPECT_NEAR(db(std::sqrt(tail)), row.tail, 1.5) << row.walker_kg << " kg on " << row.base_kg;
        std::printf("%g kg on %g kg: k1 %.1f k2 %.1f k3 %.1f k5 %.1f k7 %.1f tail %.1f dB\n", row.walker_kg,
                    row.base_kg, db(error(1)), db(error(2)), db(error(3)), db(error(5)), db(error(7)),
                    db(std::sqrt(tail)));
    }
}

TEST(PlantTableTest, EachModelFollowsItsResponse) {
    for (const char* model : {"B&K 4809", "LDS V203", "Modal Shop 2100E11"})
        for (const char* drive : {"voltage", "current"}) {
            Scene s = with(std::string{"model = \""} + model + "\"\ndrive = \"" + drive + "\"");
            s.walker.mass_kg = 1e-9;
            s.dac_full_scale_v = 100;
            const Drive asked{.gamma = 4.9, .rho = 0.4, .phi = 0.6};
            const auto last = last_period(s, asked, 200);
            for (int q = 1; q <= 3; ++q) {
                std::complex<double> want = 0;
                if (q <= 2) want = harmonics(asked).at(q) * std::polar(1.0, -q * std::numbers::pi / period);
                const double w = two_pi * 20 * q;
                const std::complex<double> a = -w * w * harmonic(last, &PlantState::x, q);
                // A held sample is late by half of one; its images fold in with (f / f_s)^2.
                EXPECT_LT(std::abs(a - want), 1e-5 * asked.gamma) << model << ", " << drive << ", " << q;
            }
        }
}

TEST(PlantTableTest, ACutThrowsASoftSuspensionAsPublished) {
    // Peak |x| after the drive is cut at the worst of 60 phases, at once or by a raised cosine; current
    // drive, gamma = 3 g, 20 Hz, rho = 1/2.
    struct Row {
        double suspension_hz, zeta;
        std::array<double, 5> peak_mm;  // ramps of 0, 10, 25, 50, 100 ms
    };
    constexpr std::array<double, 5> ramps_s{0, 0.010, 0.025, 0.050, 0.100};
    for (const Row& row :
         {Row{5, 0.05, {5.2, 4.8, 3.4, 1.5, 1.05}}, Row{13, 0.05, {2.0, 1.9, 1.5, 1.10, 1.04}},
          Row{13, 0.20, {1.7, 1.6, 1.25, 1.06, 1.04}}, Row{30, 0.05, {1.03, 1.03, 1.03, 1.03, 1.03}}}) {
        Scene s = test::one_newton_a_volt();
        const double w = two_pi * row.suspension_hz;
        s.shaker.stiffness_npm = w * w;
        s.shaker.damping_nspm = 2 * row.zeta * w;
        const auto volts = test::volts_for(s, {.gamma = 29.4});
        const auto drive = test::samples(volts, 20, s.dac_rate_hz, 0, 250 * period);
        ShakerPlant plant{s};
        for (const double v : drive) plant.step(v);  // 12.5 s: its own swing has gone
        std::array<double, 5> peak{};
        for (long phase = 0; phase < period; ++phase) {
            const double v = value_at(volts, two_pi * static_cast<double>(phase) / period);
            if (phase % (period / 60) == 0)
                for (std::size_t k = 0; k < ramps_s.size(); ++k) {
                    ShakerPlant cut = plant;
                    for (long i = 0; i < 9600; ++i) {
                        const double t = static_cast<double>(i) / s.dac_rate_hz, share = t / ramps_s[k];
                        const double on = two_pi * static_cast<double>(phase + i) / period;
                        cut.step(t < ramps_s[k]
                                     ? (0.5 + 0.5 * std::cos(std::numbers::pi * share)) * value_at(volts, on)
                                     : 0);
                        peak[k] = std::max(peak[k], 1e3 * std::abs(cut.state().x));
                    }
                }
            plant.step(v);
        }
        std::printf("%g Hz, zeta %g: %.2f %.2f %.2f %.2f %.2f mm\n", row.suspension_hz, row.zeta, peak[0],
                    peak[1], peak[2], peak[3], peak[4]);
        for (std::size_t k = 0; k < peak.size(); ++k)
            EXPECT_NEAR(peak[k] / row.peak_mm[k], 1, 0.05) << row.suspension_hz << " Hz, ramp " << ramps_s[k];
    }
}

TEST(PlantTableTest, TheGainDriftsAndTheAmplifierClips) {
    Scene s = test::one_newton_a_volt();
    s.shaker.gain_drift_per_min = 0.1;
    s.shaker.amplifier_limit_a = 1.05;
    ShakerPlant plant{s};
    for (long i = 0; i < 720000; ++i) plant.step(1);
    EXPECT_NEAR(plant.amplifier_output(), 1.025, 1e-6);  // a quarter of a minute
    plant.set_gain_factor(-0.5);
    plant.step(1);
    EXPECT_NEAR(plant.amplifier_output(), -0.5 * 1.025, 1e-6);
    plant.set_gain_factor(10);
    plant.step(1);
    EXPECT_EQ(plant.state().current, 1.05);
}

}  // namespace
}  // namespace shaker::simulated

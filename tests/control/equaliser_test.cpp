#include "daemon/control/equaliser.hpp"

#include <gtest/gtest.h>

#include <random>

namespace shaker {
namespace {

using Response = std::array<std::complex<double>, max_harmonics>;

Response nominal() {
    Response h;
    for (std::size_t k = 0; k < h.size(); ++k)
        h[k] = std::polar(80.0 + 10 * static_cast<double>(k), 1.0 - 0.2 * static_cast<double>(k));
    return h;
}

// A shaker whose response differs from the nominal one, that adds harmonics of its own, late by a delay.
struct Toy {
    Response h;
    double late = 0;   // rad of harmonic 1
    double noise = 0;  // m/s^2
    std::mt19937_64 rng{5};
    Harmonics<Acceleration> base(const Harmonics<Voltage>& volts) const {
        Harmonics<Acceleration> a;
        for (int q = 1; q <= max_harmonics; ++q) a.at(q) = h[static_cast<std::size_t>(q - 1)] * volts.at(q);
        a.at(3) += 0.03 * std::abs(a.at(1));
        return a;
    }
    Harmonics<Acceleration> measured(const Harmonics<Voltage>& volts) {
        std::normal_distribution<double> gauss{0, noise};
        Harmonics<Acceleration> a = base(volts);
        for (int q = 1; q <= max_harmonics; ++q)
            a.at(q) = a.at(q) * std::polar(1.0, -q * late) + std::complex<double>{gauss(rng), gauss(rng)};
        return a;
    }
};

// psi: phase error of the nominal response at harmonic 2 and above, beyond the turn that harmonic 1 tells.
Toy toy(double magnitude, double psi) {
    Toy t;
    t.h = nominal();
    for (std::size_t k = 0; k < t.h.size(); ++k) t.h[k] *= std::polar(magnitude, k > 0 ? psi : 0.0);
    return t;
}

TEST(EqualiserTest, BringsTheBaseToTheTargetWithAResponseThirtyPercentOff) {
    const Drive drive{.gamma = 12, .rho = 0.4, .phi = 0.7};
    for (const double psi : {0.0, 0.5, -0.8}) {
        Toy t = toy(1.3, psi);
        Equaliser eq{harmonics(drive), nominal()};
        Equaliser::Report r;
        for (int k = 0; k < 40; ++k) r = eq.update(t.measured(eq.volts()), 1e-6);
        EXPECT_TRUE(r.locked);
        const Drive got = drive_of(t.base(eq.volts()), 20);
        EXPECT_NEAR(got.gamma, 12, 1e-3);
        EXPECT_NEAR(got.rho, 0.4, 1e-4);
        EXPECT_NEAR(got.phi, 0.7, 1e-3);
        EXPECT_LT(std::abs(t.base(eq.volts()).at(3)), 1e-3);
    }
}

TEST(EqualiserTest, DivergesBeyondItsStatedLimitAndNotBelow) {
    // psi = 1.2 rad: the limit is 2 cos(1.2)/1 = 0.7247.
    for (const double gain : {0.70, 0.75}) {
        Toy t = toy(1, 1.2);
        Equaliser eq{
            harmonics(Drive{.gamma = 5}), nominal(), {.harmonics = 2, .gain = gain, .volts_limit = 1e9}};
        for (int k = 0; k < 2000; ++k) eq.update(t.measured(eq.volts()), 1e-6);
        const double error = std::abs(t.base(eq.volts()).at(2) - 2.5);
        EXPECT_EQ(error < 1e-3, gain < 0.7247) << "gain " << gain << ", error " << error;
    }
}

TEST(EqualiserTest, AConstantDelayDoesNotMatter) {
    for (const double late : {0.0, 0.3, -1.1}) {
        Toy t = toy(1.1, 0.1);
        t.late = late;
        Equaliser eq{harmonics(Drive{.gamma = 9.8, .phi = 1.2}), nominal()};
        for (int k = 0; k < 60; ++k) eq.update(t.measured(eq.volts()), 1e-6);
        const Drive got = drive_of(t.base(eq.volts()), 20);
        EXPECT_NEAR(got.phi, 1.2, 1e-6) << "late " << late;
        EXPECT_NEAR(got.gamma, 9.8, 1e-6);
    }
}

TEST(EqualiserTest, NoiseDoesNotKeepItFromLocking) {
    Toy t = toy(0.8, 0.3);
    t.noise = 0.02;
    Equaliser eq{harmonics(Drive{.gamma = 9.8}), nominal()};
    int locked = 0;
    for (int k = 0; k < 60; ++k) locked += eq.update(t.measured(eq.volts()), t.noise).locked ? 1 : 0;
    EXPECT_GT(locked, 15);  // eight complex errors within three sd at once: about every second period
}

TEST(EqualiserTest, TheLimitScalesTheShapeAndSaysSo) {
    Toy t = toy(1, 0);
    const Drive drive{.gamma = 100, .rho = 0.5, .phi = 0.4};
    Equaliser eq{harmonics(drive), nominal(), {.volts_limit = 0.5}};
    Equaliser::Report r;
    for (int k = 0; k < 100; ++k) {
        r = eq.update(t.measured(eq.volts()), 1e-6);
        ASSERT_LE(peak(eq.volts()), 0.5 * (1 + 1e-3));  // 512 points with a parabola: 3e-5 at 16 harmonics
    }
    const Drive got = drive_of(t.base(eq.volts()), 20);
    EXPECT_NEAR(got.gamma, 100 * r.reached, 0.05 * got.gamma);
    EXPECT_LT(r.reached, 1);
    EXPECT_NEAR(got.rho, 0.5, 0.01);
    EXPECT_NEAR(got.phi, 0.4, 0.02);
}

TEST(EqualiserTest, NeverRaisesTheDriveOnMissingOrBrokenData) {
    Equaliser eq{harmonics(Drive{.gamma = 9.8}), nominal()};
    const Harmonics<Voltage> before = eq.volts();
    Harmonics<Acceleration> broken;
    EXPECT_FALSE(eq.update(broken, 1e-3).locked);  // nothing moves
    broken.at(1) = NAN;
    EXPECT_FALSE(eq.update(broken, 1e-3).locked);
    EXPECT_EQ(eq.volts(), before);
}

TEST(EqualiserTest, PeakIsTheLargestValueOfThePeriod) {
    Harmonics<Voltage> h;
    h.at(1) = std::polar(0.7, 0.3);
    EXPECT_NEAR(peak(h), 0.7, 1e-7);
    h.at(16) = std::polar(0.1, 1.0);
    double largest = 0;
    for (int i = 0; i < 1'000'000; ++i) largest = std::max(largest, std::abs(value_at(h, two_pi * 1e-6 * i)));
    EXPECT_NEAR(peak(h), largest, 1e-4 * largest);
}

}  // namespace
}  // namespace shaker

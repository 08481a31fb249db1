#include "daemon/control/equaliser.hpp"

#include <gtest/gtest.h>

#include <random>

namespace shaker::control {
namespace {

using Response = std::array<std::complex<double>, max_harmonics>;

Response nominal() {
    Response h;
    for (std::size_t k = 0; k < h.size(); ++k)
        h[k] = std::polar(80.0 + 10 * static_cast<double>(k), 1.0 - 0.2 * static_cast<double>(k));
    return h;
}

// A shaker with a response that differs from the nominal one, its own harmonics and a delay.
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

// psi: phase error of the nominal response at harmonic 2 and above, minus the phase error of harmonic 1.
Toy toy(double magnitude, double psi) {
    Toy t;
    t.h = nominal();
    for (std::size_t k = 0; k < t.h.size(); ++k) t.h[k] *= std::polar(magnitude, k > 0 ? psi : 0.0);
    return t;
}

// Gives the equaliser `windows` windows of settled motion.
Equaliser::Report run(Equaliser& eq, Toy& t, int windows, double sd = 1e-6) {
    Equaliser::Report r;
    for (int k = 0; k < windows; ++k) r = eq.take({t.measured(eq.volts()), sd, eq.volts(), true});
    return r;
}

TEST(EqualiserTest, ReachesTargetForAnyCommonGainOfTheResponse) {
    const Drive drive{.gamma = 12, .rho = 0.4, .phi = 0.7};
    for (const auto& [magnitude, psi] :
         {std::pair{1.3, 0.5}, {1.3, -0.8}, {5.0, 0.0}, {0.2, 0.0}, {1.0, 0.0}}) {
        Toy t = toy(magnitude, psi);
        Equaliser eq{harmonics(drive), nominal(), {.volts_limit = 1e3}};
        const auto r = run(eq, t, 250);
        EXPECT_TRUE(r.locked) << magnitude << " " << psi;
        const Drive got = drive_of(t.base(eq.volts()), 20);
        EXPECT_NEAR(got.gamma, 12, 1e-3);
        EXPECT_NEAR(got.rho, 0.4, 1e-4);
        EXPECT_NEAR(got.phi, 0.7, 1e-3);
        EXPECT_LT(std::abs(t.base(eq.volts()).at(3)), 2e-3);
    }
}

TEST(EqualiserTest, RisesInLevelsWithoutLargeOvershoot) {
    Toy t = toy(1.3, 0.4);
    Equaliser eq{harmonics(Drive{.gamma = 9.8}), nominal(), {.volts_limit = 1e3}};
    EXPECT_NEAR(
        peak(eq.volts()),
        0.4 * peak(Equaliser{
                  harmonics(Drive{.gamma = 9.8}), nominal(), {.volts_limit = 1e3, .from_below = false}}
                       .volts()),
        1e-9);
    for (int k = 0; k < 200; ++k) {
        run(eq, t, 1);
        double largest = 0;
        for (int i = 0; i < 200; ++i)
            largest = std::max(largest, std::abs(value_at(t.base(eq.volts()), two_pi * i / 200)));
        ASSERT_LT(largest, 1.2 * 9.8) << "window " << k;
    }
}

TEST(EqualiserTest, IgnoresConstantAndDriftingDelay) {
    for (const double drift : {0.0, 1e-3}) {
        Toy t = toy(1.1, 0.1);
        t.late = -0.6;
        Equaliser eq{harmonics(Drive{.gamma = 9.8, .phi = 1.2}), nominal()};
        for (int k = 0; k < 400; ++k, t.late += drift) run(eq, t, 1);
        const Drive got = drive_of(t.base(eq.volts()), 20);
        EXPECT_NEAR(got.phi, 1.2, 1e-5) << "drift " << drift;
        EXPECT_NEAR(got.gamma, 9.8, 1e-4);
    }
}

// A sensor that is 7 ms late turns a harmonic of 20 Hz by 50 degrees, one of 40 Hz by 100.
TEST(EqualiserTest, ReachesTargetThroughALateSensor) {
    for (const double late : {-2.5, -0.9, 0.5, 0.9, 1.5, 2.5}) {
        Toy t = toy(1.2, 0.2);
        t.late = late;
        Equaliser eq{harmonics(Drive{.gamma = 9.8, .phi = 0.4}), nominal(), {.volts_limit = 1e3}};
        int windows = 0;
        for (bool locked = false; !locked && windows < 300; ++windows) {
            locked = run(eq, t, 1).locked;
            ASSERT_LT(drive_of(t.base(eq.volts()), 20).gamma, 1.2 * 9.8) << late << ", window " << windows;
        }
        EXPECT_LT(windows, 60) << late;
        EXPECT_NEAR(drive_of(t.base(eq.volts()), 20).phi, 0.4, 5e-3) << late;
    }
}

// A resonance turns one harmonic: the others are not turned with it.
TEST(EqualiserTest, PhaseErrorOfOneHarmonicIsNoDelay) {
    for (const double rho : {0.4, 1.0})
        for (const double turn : {0.5, 0.8, 1.2}) {
            Toy t = toy(1.2, 0);
            t.h[0] *= std::polar(1.0, turn);
            Equaliser eq{harmonics(Drive{.gamma = 9.8, .rho = rho}), nominal(), {.volts_limit = 1e3}};
            int windows = 0;
            for (bool locked = false; !locked && windows < 300; ++windows) {
                locked = run(eq, t, 1).locked;
                double sum = 0;
                for (const auto& a : t.base(eq.volts()).a) sum += std::abs(a);
                ASSERT_LT(sum, 1.4 * 9.8) << rho << " " << turn << ", window " << windows;
            }
            EXPECT_LT(windows, 80) << rho << " " << turn;
        }
}

TEST(EqualiserTest, AttenuatesNoiseInTheDrive) {
    Toy t = toy(0.9, 0.1);
    t.noise = 0.002;
    Equaliser eq{harmonics(Drive{.gamma = 9.8}), nominal(), {.noise = t.noise}};
    run(eq, t, 200, t.noise);
    double squares = 0;
    constexpr int windows = 4000;
    for (int k = 0; k < windows; ++k) {
        run(eq, t, 1, t.noise);
        squares += std::norm(t.base(eq.volts()).at(4)) / windows;
    }
    // Type 1 makes sqrt(mu / (2 - mu)) = 0.229 of it at mu = 0.1; the slow sum adds a little.
    EXPECT_NEAR(std::sqrt(squares) / (t.noise * std::sqrt(2)), 0.24, 0.03);
}

TEST(EqualiserTest, HeldDriveChangesByItsMeanErrorOnly) {
    Toy t = toy(0.9, 0.1);
    t.noise = 0.002;
    Equaliser eq{harmonics(Drive{.gamma = 9.8}), nominal(), {.noise = t.noise}};
    run(eq, t, 200, t.noise);
    eq.hold();
    run(eq, t, 1, t.noise);
    const Harmonics<Voltage> held = eq.volts();
    for (int k = 0; k < longest_hold - 2; ++k) {
        EXPECT_GT(run(eq, t, 1, t.noise).held, 0) << k;
        ASSERT_EQ(eq.volts().a, held.a) << k;
    }
    EXPECT_EQ(run(eq, t, 1, t.noise).held, 0);
    EXPECT_NE(eq.volts().a, held.a);
    run(eq, t, 900, t.noise);
    double squares = 0;
    for (int q = 3; q <= 8; ++q) squares += std::norm(t.base(eq.volts()).at(q)) / 6;
    // the mean of 100 windows before and of 1000 held ones
    EXPECT_NEAR(std::sqrt(squares / 2) / t.noise, 1 / std::sqrt(1100), 0.5 / std::sqrt(1100));
}

TEST(EqualiserTest, HeldDriveFollowsAPlantThatChanges) {
    for (const double change : {1.0005, 1.01, 1.2}) {
        Toy t = toy(0.9, 0.1);
        t.noise = 0.002;
        Equaliser eq{harmonics(Drive{.gamma = 9.8}), nominal(), {.volts_limit = 1e3, .noise = t.noise}};
        run(eq, t, 200, t.noise);
        eq.hold();
        run(eq, t, 20, t.noise);
        for (auto& h : t.h) h *= change;
        run(eq, t, 300, t.noise);
        EXPECT_NEAR(drive_of(t.base(eq.volts()), 20).gamma, 9.8, 2e-4 * 9.8) << change;
    }
}

// Held from the first judged window on, a drive is the mean of several windows, not what one of them shows.
TEST(EqualiserTest, DriveThatIsHeldAtOnceIsAsGoodAsItsWindows) {
    constexpr int seeds = 200;
    double squares = 0;
    int changed = 0;
    for (unsigned seed = 0; seed < seeds; ++seed) {
        Toy t = toy(0.98, 0.02);
        t.noise = 0.002;
        t.rng.seed(seed);
        Equaliser eq{harmonics(Drive{.gamma = 9.8}), nominal(), {.noise = t.noise}};
        eq.hold();
        int windows = 0;
        while (run(eq, t, 1, t.noise).held < 2 && windows < 300) ++windows;
        ASSERT_LT(windows, 300) << seed;
        for (int q = 3; q <= 8; ++q) squares += std::norm(t.base(eq.volts()).at(q)) / 6 / seeds;
        const Harmonics<Voltage> held = eq.volts();
        run(eq, t, 40, t.noise);  // as a measurement
        changed += eq.volts().a != held.a;
    }
    EXPECT_LT(std::sqrt(squares / 2) / 0.002, 0.6) << "of the noise of one window";
    EXPECT_LE(changed, seeds / 10)
        << "a drive that stands out of the noise is corrected while it is measured";
}

// Mains that lie on harmonic 5 look like motion; nothing is driven against them.
TEST(EqualiserTest, HarmonicThatIsHiddenIsNotDriven) {
    for (const bool hidden : {false, true}) {
        Toy t = toy(0.9, 0.1);
        EqualiserSettings settings;
        if (hidden) settings.hidden = {5};
        Equaliser eq{harmonics(Drive{.gamma = 9.8}), nominal(), settings};
        Equaliser::Report r;
        for (int k = 0; k < 200; ++k) {
            auto seen = t.measured(eq.volts());
            seen.at(5) += std::polar(0.2, 0.005 * k);
            r = eq.take({seen, 1e-6, eq.volts(), true});
        }
        const double made = std::abs(t.base(eq.volts()).at(5));
        EXPECT_EQ(made < 1e-3, hidden) << made;
        EXPECT_NEAR(drive_of(t.base(eq.volts()), 20).gamma, 9.8, 1e-3 * 9.8);
        EXPECT_TRUE(r.locked);
    }
}

TEST(EqualiserTest, KnownTargetGetsItsDriveAgain) {
    Toy t = toy(0.9, 0.1);
    t.noise = 0.002;
    const auto here = harmonics(Drive{.gamma = 9.8}), there = harmonics(Drive{.gamma = 9.8, .phi = 3});
    Equaliser eq{here, nominal(), {.noise = t.noise}};
    run(eq, t, 200, t.noise);
    eq.hold();
    run(eq, t, 50, t.noise);
    const Harmonics<Voltage> known = eq.volts();
    eq.retarget(there);
    run(eq, t, 60, t.noise);
    eq.retarget(here, &known);
    for (int k = 0; k < 60; ++k) {
        ASSERT_EQ(eq.volts().a, known.a) << k;
        run(eq, t, 1, t.noise);
    }
    Harmonics<Voltage> other = known;
    for (auto& v : other.a) v *= 1.3;
    eq.retarget(there);
    eq.retarget(here, &other);
    EXPECT_NE(eq.volts().a, other.a) << "30 % off what the plant predicts";
}

TEST(EqualiserTest, ReportsNoiseLimitedAccuracy) {
    Toy t = toy(1, 0);
    t.noise = 0.03;
    Equaliser eq{harmonics(Drive{.gamma = 9.8}), nominal(), {.noise = t.noise}};
    EXPECT_TRUE(run(eq, t, 200, t.noise).noise_limited);
    t.noise = 0.001;
    Equaliser quiet{harmonics(Drive{.gamma = 9.8}), nominal(), {.noise = t.noise}};
    EXPECT_FALSE(run(quiet, t, 200, t.noise).noise_limited);
}

TEST(EqualiserTest, ScalesShapeAtVoltageLimitAndReportsIt) {
    Toy t = toy(1, 0);
    const Drive drive{.gamma = 100, .rho = 0.5, .phi = 0.4};
    Equaliser eq{harmonics(drive), nominal(), {.volts_limit = 0.5}};
    Equaliser::Report r;
    for (int k = 0; k < 200; ++k) {
        r = run(eq, t, 1);
        ASSERT_LE(peak(eq.volts()), 0.5 * (1 + 1e-3));  // 512 points with a parabola: 3e-5 at 16 harmonics
    }
    const Drive got = drive_of(t.base(eq.volts()), 20);
    EXPECT_NEAR(got.gamma, 100 * r.reached, 0.02 * got.gamma);
    EXPECT_LT(r.reached, 1);
    EXPECT_NEAR(got.rho, 0.5, 0.002);
    EXPECT_NEAR(got.phi, 0.4, 0.005);
}

TEST(EqualiserTest, KeepsDriveOnMissingOrInvalidData) {
    Toy t = toy(1, 0);
    for (const int before : {0, 5, 200}) {  // at the start, converging, tracking
        Equaliser eq{harmonics(Drive{.gamma = 9.8}), nominal()};
        run(eq, t, before);
        const Harmonics<Voltage> volts = eq.volts();
        Harmonics<Acceleration> broken;
        for (int k = 0; k < 50; ++k) {
            const auto r = eq.take({broken, 1e-3, volts, true});
            EXPECT_TRUE(r.no_motion);
            EXPECT_FALSE(before == 0 && r.locked);
        }
        broken.at(1) = NAN;
        eq.take({broken, 1e-3, volts, true});
        eq.take({t.measured(volts), NAN, volts, true});
        EXPECT_EQ(eq.volts(), volts);
    }
}

TEST(EqualiserTest, StepsToNewTargetByLearnedPlant) {
    Toy t = toy(1.3, 0.3);
    t.late = 0.4;
    Equaliser eq{harmonics(Drive{.gamma = 9.8}), nominal(), {.volts_limit = 1e3}};
    run(eq, t, 250);
    const Drive next{.gamma = 14.7, .rho = 0.5, .phi = 1.5};
    eq.retarget(harmonics(next));
    Drive got = drive_of(t.base(eq.volts()), 20);
    EXPECT_NEAR(got.gamma, 14.7, 0.3);
    EXPECT_NEAR(got.phi, 1.5, 0.15);
    run(eq, t, 100);
    got = drive_of(t.base(eq.volts()), 20);
    EXPECT_NEAR(got.gamma, 14.7, 1e-3);
    EXPECT_NEAR(got.phi, 1.5, 1e-4);
}

TEST(EqualiserTest, HoldsLastGoodDriveOfSaturatedPlant) {
    Toy t = toy(1, 0);
    Equaliser eq{harmonics(Drive{.gamma = 9.8}), nominal(), {.volts_limit = 1e3}};
    Equaliser::Report r;
    for (int k = 0; k < 600; ++k) {  // harmonic 1 saturates at 0.8 of the request
        Harmonics<Acceleration> a = t.measured(eq.volts());
        const double size = std::abs(a.at(1));
        a.at(1) *= 3.92 * std::tanh(size / 3.92) / size;
        r = eq.take({a, 1e-6, eq.volts(), true});
    }
    EXPECT_TRUE(r.unreachable);
    EXPECT_LT(r.reached, 0.95);
    EXPECT_GT(r.reached, 0.3);
}

// A walker that begins to slide takes a fifth of the motion from one window to the next.
TEST(EqualiserTest, RecoversFromPlantChangeAfterStep) {
    for (int after = 1; after <= 12; ++after) {
        Toy t = toy(1, 0);
        Equaliser eq{harmonics(Drive{.gamma = 9.8}), nominal(), {.volts_limit = 1e3}};
        ASSERT_TRUE(run(eq, t, 120).locked);
        for (std::complex<double>& h : t.h) h *= 0.8;
        run(eq, t, 3 + after);
        for (std::complex<double>& h : t.h) h /= 0.8;
        const auto r = run(eq, t, 60);
        EXPECT_LT(r.error, 1e-3) << after;
    }
}

TEST(EqualiserTest, PeakIsLargestValueOfThePeriod) {
    Harmonics<Voltage> h;
    h.at(1) = std::polar(0.7, 0.3);
    EXPECT_NEAR(peak(h), 0.7, 1e-7);
    h.at(16) = std::polar(0.1, 1.0);
    double largest = 0;
    for (int i = 0; i < 1'000'000; ++i) largest = std::max(largest, std::abs(value_at(h, two_pi * 1e-6 * i)));
    EXPECT_NEAR(peak(h), largest, 1e-4 * largest);
}

}  // namespace
}  // namespace shaker::control

#include "drivers/simulated/shaker_plant.hpp"

#include <gtest/gtest.h>

#include "drivers/walker/steady_state.hpp"
#include "tests/support/control/bench_drive.hpp"

namespace shaker::simulated {
namespace {

constexpr double rate = 48000;
constexpr long period = 2400;  // samples at 20 Hz

struct Played {
    std::vector<PlantState> last;  // of the last period
    double drift = 0;              // m/s over the last period
    long events = 0;               // in the last period
};

Played play(const Scene& scene, const Drive& drive, long periods) {
    ShakerPlant plant{scene};
    const auto volts = test::samples(test::volts_for(scene, drive), drive.frequency, rate, 0,
                                     static_cast<std::size_t>(periods * period));
    Played p;
    double from = 0;
    for (std::size_t i = 0; i < volts.size(); ++i) {
        if (i + period == volts.size()) {
            from = plant.state().walker_x;
            p.events = -plant.events();
        }
        if (i + period >= volts.size()) p.last.push_back(plant.state());
        plant.step(volts[i]);
    }
    p.drift = (plant.state().walker_x - from) * 20;
    p.events += plant.events();
    return p;
}

// Complex amplitude of harmonic q of the last period's base acceleration.
std::complex<double> harmonic(const Played& p, int q) {
    std::complex<double> sum = 0;
    for (std::size_t i = 0; i < p.last.size(); ++i)
        sum += p.last[i].a * std::polar(1.0, -two_pi * q * static_cast<double>(i) / period);
    return std::complex<double>{0, 1} * sum * 2.0 / static_cast<double>(period);
}

Scene light_walker() {
    Scene s = paper_scene();
    s.walker.mass_kg = 1e-9;
    return s;
}

TEST(ShakerPlantTest, FollowsTransferFunctionWithoutWalker) {
    const Drive drive{.gamma = 14.7, .rho = 0.4, .phi = 0.6};
    const Played p = play(light_walker(), drive, 100);
    // A held sample delays by half a sample: q pi f / f_s. Its images at multiples of 48 kHz, which the coil
    // lets through at 1e-5 of the signal, fold into these sums.
    for (int q = 1; q <= 2; ++q) {
        const std::complex<double> want =
            harmonics(drive).at(q) * std::polar(1.0, -q * std::numbers::pi / period);
        EXPECT_LT(std::abs(harmonic(p, q) - want), 3e-5 * 14.7) << "harmonic " << q;
    }
    EXPECT_LT(std::abs(harmonic(p, 3)), 1e-6);
}

TEST(ShakerPlantTest, MasslessWalkerMatchesExactWalker) {
    for (const Drive& drive :
         {Drive{.gamma = 9.8}, Drive{.gamma = 4.9}, Drive{.gamma = 19.6, .phi = 1.5707963}}) {
        walker::WalkerSetting setting;
        setting.base = harmonics(drive);
        const walker::SteadyState exact = walker::settle(walker::WalkerLaw{setting});
        const Played p = play(light_walker(), drive, 120);
        // The remainder is the plant's own approach to its cycle; contact changes lie exactly inside the
        // samples.
        EXPECT_NEAR(p.drift, exact.v_D, 2e-6 * drive.gamma / (two_pi * 20)) << "gamma " << drive.gamma;
        EXPECT_EQ(p.events, static_cast<long>(exact.events.size()));
    }
}

TEST(ShakerPlantTest, WalkersReactionHasOddHarmonics) {
    // Two slips of half a period at +-mu m g: a square force, harmonic 3 of a_B = 4 mu m g / (3 pi M) through
    // the mechanical response; the published figure for 60 g on 0.33 kg at 1 g is -41 dB of gamma.
    Scene s = paper_scene();
    s.shaker.base_mass_kg = 0.33 - s.shaker.moving_mass_kg;
    const Played p = play(s, Drive{.gamma = 9.8}, 120);
    EXPECT_NEAR(20 * std::log10(std::abs(harmonic(p, 3)) / 9.8), -41, 3);
    EXPECT_LT(20 * std::log10(std::abs(std::abs(harmonic(p, 2)) - 4.9) / 9.8),
              -50);  // slips of T/2: no even part
}

TEST(ShakerPlantTest, WalkerSticksBelowThreshold) {
    const Played p = play(paper_scene(), Drive{.gamma = 0.12 * 9.8}, 60);
    EXPECT_EQ(p.events, 0);
    EXPECT_NEAR(p.drift, 0, 1e-9);
    for (const PlantState& s : p.last) EXPECT_EQ(s.slip, 0);
}

TEST(ShakerPlantTest, TheAmplifierClips) {
    Scene s = light_walker();
    s.shaker.amplifier_limit_v = 0.2;
    const Played p = play(s, Drive{.gamma = 9.8}, 60);
    EXPECT_LT(std::abs(harmonic(p, 1)), 0.5 * 4.9);
    EXPECT_GT(std::abs(harmonic(p, 3)), 0.05);
}

}  // namespace
}  // namespace shaker::simulated

#include <gtest/gtest.h>

#include <vector>

#include "daemon/control/period_windows.hpp"

namespace shaker::control {
namespace {

constexpr double rate = 48000;

DriveCommand command(double volts, double frequency, int ramp, std::uint64_t sequence) {
    DriveCommand c{.volts = {}, .frequency = frequency, .ramp_periods = ramp, .sequence = sequence};
    c.volts.at(1) = volts;
    return c;
}

// Plays a list of commands, each given at a sample, and passes the changes to a history.
struct Played {
    Synthesiser synthesiser{rate, 20, 10};
    DriveHistory history{rate, 20};
    std::vector<double> volts;
    void on(std::int64_t samples) {
        std::vector<double> block(48);
        for (std::int64_t n = 0; n < samples; n += 48) {
            synthesiser.fill(block);
            volts.insert(volts.end(), block.begin(), block.end());
            if (synthesiser.change() != nullptr) history.add(*synthesiser.change());
        }
    }
};

TEST(DriveHistoryTest, PhaseEqualsSynthesisersThroughFrequencyChanges) {
    Played p;
    p.on(4800);
    double frequency = 20;
    for (std::uint64_t k = 1; k < 40; ++k) {
        frequency = 20 + 3.7 * static_cast<double>(k % 5);
        p.synthesiser.set(command(1, frequency, 1 + static_cast<int>(k % 3), k));
        p.on(24000);
        const double exact = static_cast<double>(static_cast<long double>(p.synthesiser.phase()) * 0x1p-128L);
        const double turns = p.history.turns(static_cast<double>(p.synthesiser.tick().n) / rate);
        EXPECT_LT(std::abs(std::remainder(turns - exact, 1)), 1e-9) << "change " << k;
    }
    EXPECT_EQ(p.history.frequency(), frequency);
    EXPECT_EQ(p.history.sequence(), 39U);
}

TEST(DriveHistoryTest, MeanEqualsThatOfTheSamples) {
    Played p;
    p.on(2400);
    p.synthesiser.set(command(1, 20, 3, 1));
    p.on(14400);
    p.synthesiser.set(command(0.25, 20, 1, 2));
    p.on(14400);
    for (int period = 0; period < 12; ++period) {
        const double from = 0.05 * period;
        double sum = 0;  // lock-in over the period
        for (std::size_t i = 0; i < 2400; ++i)
            sum += p.volts[2400 * static_cast<std::size_t>(period) + i] *
                   std::sin(two_pi * static_cast<double>(i) / 2400) / 1200;
        // A ramp distorts the sine slightly, and lock-in and mean change by different amounts.
        EXPECT_NEAR(p.history.mean(from, from + 0.05).at(1).real(), sum, 0.06) << period;
        const bool steady = period == 0 || (period >= 4 && period <= 6) || period >= 8;
        EXPECT_EQ(p.history.steady(from, from + 0.05), steady) << period;
    }
}

TEST(DriveHistoryTest, ChangesThatWereTakenBackAreForgotten) {
    Played p;
    p.on(4800);
    p.synthesiser.set(command(1, 20, 1, 1));
    p.on(9600);
    const Synthesiser before = p.synthesiser;
    p.synthesiser.set(command(0.5, 31, 1, 2));
    p.on(4800);
    EXPECT_EQ(p.history.frequency(), 31);
    const std::int64_t generated = p.synthesiser.tick().n;
    p.synthesiser.go_back(before, {});
    p.synthesiser.stop(240);
    DriveChange stop = *p.synthesiser.change();
    stop.taken_back = generated - p.synthesiser.tick().n;
    p.history.add(stop);
    EXPECT_EQ(p.history.frequency(), 20);
    EXPECT_EQ(p.history.in_force_s(), static_cast<double>(stop.first.n + 240) / rate);
    const double s = static_cast<double>(stop.first.n) / rate;
    EXPECT_EQ(p.history.mean(s - 0.05, s).at(1), std::complex<double>{1});
    const double exact = static_cast<double>(static_cast<long double>(p.synthesiser.phase()) * 0x1p-128L);
    EXPECT_LT(std::abs(std::remainder(p.history.turns(s) - exact, 1)), 1e-9);
}

}  // namespace
}  // namespace shaker::control

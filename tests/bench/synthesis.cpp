// Cost and error of synthesising the drive, against other methods, and splatter of a change during the run.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <optional>
#include <string>

#include "drivers/synthesiser.hpp"
#include "tests/bench/table.hpp"
#include "tests/support/cost.hpp"
#include "tests/support/tracking/splatter.hpp"

namespace shaker {
namespace {

constexpr double rate = 48000;
constexpr double f = 20;
constexpr std::int64_t period = 2400;
constexpr std::int64_t far = 1'000'000'000;  // samples: 5.8 h
constexpr std::size_t block = 256;
constexpr int blocks = 200;
constexpr int repeats = 21;
using Block = std::array<double, block>;

const std::string conditions = "20 Hz at 48 kHz, blocks of 256, median of 21 x 51200 samples";

/// K harmonics of equal amplitude with a sum of full scale.
DriveCommand equal_harmonics(int order, double turn) {
    DriveCommand c;
    for (int q = 1; q <= order; ++q) c.volts.at(q) = std::polar(1.0 / order, turn * q);
    return c;
}

/// Exact signal at sample n: the phase as a ratio of integers, sines in long double.
double exact(const Harmonics<Voltage>& from, const Harmonics<Voltage>& to, long double weight,
             std::int64_t n) {
    long double sum = 0;
    for (int q = 1; q <= max_harmonics; ++q) {
        const long double angle =
            2 * std::numbers::pi_v<long double> * static_cast<long double>(q * n % period) / period;
        const long double re = from.at(q).real() + weight * (to.at(q).real() - from.at(q).real());
        const long double im = from.at(q).imag() + weight * (to.at(q).imag() - from.at(q).imag());
        sum += re * std::sin(angle) + im * std::cos(angle);
    }
    return static_cast<double>(sum);
}

template <class Fill>
double cost_a_sample(Fill fill) {
    Block volts{};
    return bench::median_cost_ns(repeats,
                                 [&] {
                                     for (int i = 0; i < blocks; ++i) fill(volts);
                                 }) /
           (block * blocks);
}

/// Largest error in two periods of steady signal after `far` samples, or over a ramp that starts there.
double error_of_ours(int order, bool ramped) {
    Synthesiser synth{rate, f, 2};
    const DriveCommand first = equal_harmonics(order, 0.7);
    const DriveCommand second = equal_harmonics(order, -1.9);
    synth.set(first);
    synth.skip(far);
    if (ramped) synth.set(second);
    std::optional<std::int64_t> begin;
    double worst = 0;
    for (std::int64_t n = far; n < far + 2 * period; ++n) {
        double volts = 0;
        synth.fill({&volts, 1});
        if (synth.change()) begin = n;
        const auto done = begin ? static_cast<long double>(std::min(n - *begin, period)) / period : 0;
        const long double weight = 0.5L - 0.5L * std::cos(std::numbers::pi_v<long double> * done);
        worst = std::max(worst, std::abs(volts - exact(first.volts, second.volts, weight, n)));
    }
    return worst;
}

double cost_of_ours(int order, bool ramped) {
    Synthesiser synth{rate, f, 2};
    DriveCommand c = equal_harmonics(order, 0.7);
    synth.set(c);
    synth.skip(2 * period);
    if (ramped) {
        c = equal_harmonics(order, -1.9);
        c.ramp_periods = 1'000'000;
        synth.set(c);
    }
    return cost_a_sample([&](Block& volts) { synth.fill(volts); });
}

/// Simple reference: two harmonics from the C library's sine. `Phase` is the type of the phase counter.
template <class Phase>
class TwoSines {
public:
    double next() {
        const double sample = phase_.sine(1, 0.7) / 2 + phase_.sine(2, 1.4) / 2;
        phase_.advance();
        return sample;
    }
    void skip(std::int64_t samples) {
        for (std::int64_t i = 0; i < samples; ++i) phase_.advance();
    }

private:
    Phase phase_;
};

struct Integer64 {
    std::uint64_t phase = 0;
    std::uint64_t step = static_cast<std::uint64_t>(std::llround(0x1p64L * f / rate));
    void advance() { phase += step; }
    [[nodiscard]] double sine(std::uint64_t q, double offset) const {
        return std::sin(static_cast<double>(static_cast<std::int64_t>(q * phase)) * (two_pi * 0x1p-64) +
                        offset);
    }
};

template <class Real>
struct Accumulator {
    Real turns = 0;
    void advance() {
        turns += static_cast<Real>(f / rate);
        if (turns >= 1) turns -= 1;
    }
    [[nodiscard]] double sine(int q, double offset) const {
        return static_cast<double>(
            std::sin(static_cast<Real>(two_pi) * static_cast<Real>(q) * turns + static_cast<Real>(offset)));
    }
};

template <class Phase>
void add_peer(bench::Table& table, const std::string& method) {
    std::fprintf(stderr, "%s: counting to 1e9\n", method.c_str());
    TwoSines<Phase> timed;
    const double cost = cost_a_sample([&](Block& volts) {
        for (double& v : volts) v = timed.next();
    });
    TwoSines<Phase> late;
    late.skip(far);
    const DriveCommand same = equal_harmonics(2, 0.7);
    double worst = 0;
    for (std::int64_t n = far; n < far + period; ++n)
        worst = std::max(worst, std::abs(late.next() - exact(same.volts, same.volts, 0, n)));
    table.add({{"method", method},
               {"harmonics", 2.0},
               {"cost", cost, "ns a sample"},
               {"error after 1e9 samples", worst, "of full scale"},
               {"conditions", conditions}});
}

void add_ours(bench::Table& table, int order, bool ramped) {
    table.add({{"method", ramped ? "shakerd, ramped" : "shakerd, steady"},
               {"harmonics", static_cast<double>(order)},
               {"cost", cost_of_ours(order, ramped), "ns a sample"},
               {"error after 1e9 samples", error_of_ours(order, ramped), "of full scale"},
               {"conditions", conditions}});
}

/// Computes all samples in between instead of jumping: takes some seconds.
void add_long_run(bench::Table& table) {
    std::fprintf(stderr, "making 1e9 samples\n");
    Synthesiser synth{rate, f, 2};
    const DriveCommand c = equal_harmonics(max_harmonics, 0.7);
    synth.set(c);
    Block volts{};
    const double before = bench::cpu_ns();
    while (synth.tick().n < far) synth.fill(volts);
    const double cost = (bench::cpu_ns() - before) / static_cast<double>(synth.tick().n);
    std::int64_t n = synth.tick().n;
    double worst = 0;
    for (int i = 0; i < 20; ++i) {
        synth.fill(volts);
        for (const double v : volts) worst = std::max(worst, std::abs(v - exact(c.volts, c.volts, 0, n++)));
    }
    table.add({{"method", "shakerd, steady, no jump"},
               {"harmonics", static_cast<double>(max_harmonics)},
               {"cost", cost, "ns a sample"},
               {"error after 1e9 samples", worst, "of full scale"},
               {"conditions", "20 Hz at 48 kHz, blocks of 256, one run of 1e9 samples"}});
}

void add_splatter(bench::Table& table) {
    const DriveCommand from = test::biharmonic(0.6, 0, f);
    const DriveCommand to = test::biharmonic(1, two_pi / 4, f);
    const auto add = [&](const char* method, const std::vector<double>& signal) {
        table.add({{"method", method},
                   {"harmonics", 2.0},
                   {"splatter above 500 Hz", test::splatter_db(signal, rate, 500), "dB", 4},
                   {"conditions", "gamma 0.6 -> 1, phi 0 -> 90 deg, 1.4 s around the change"}});
    };
    add("shakerd, live change over one period", test::around_ramp(from, to));
    add("jump at the start of a period", test::around_jump(from, to));
}

}  // namespace
}  // namespace shaker

int main(int argc, char** argv) {
    using namespace shaker;
    bench::Table table;
    for (const int order : {1, 2, 8, 16})
        for (const bool ramped : {false, true}) add_ours(table, order, ramped);
    add_long_run(table);
    add_peer<Integer64>(table, "64-bit phase, libm sin a harmonic");
    add_peer<Accumulator<double>>(table, "double accumulator, libm sin");
    add_peer<Accumulator<float>>(table, "float accumulator, sinf");
    add_splatter(table);
    table.print(argc, argv);
}

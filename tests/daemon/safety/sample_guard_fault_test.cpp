// The residual check trips for every fault of signal or plant, in every state of the drive, and never in
// normal operation.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <functional>
#include <memory>
#include <string>

#include "tests/support/safety/guard_bench.hpp"

namespace shaker::safety {
namespace {

using test::GuardBench;

struct Fault {
    const char* name;
    std::function<void(GuardBench&)> begin;
    std::vector<Cause> causes;  // each of them is right
    double budget_s = 0.02;
    double gamma = paper_g;
};

std::ostream& operator<<(std::ostream& out, const Fault& fault) { return out << fault.name; }

const std::vector<Fault> faults{
    {"Open",
     [](GuardBench& b) {
         auto rng = std::make_shared<std::mt19937>(3);
         b.sensor = [rng](double, GuardBench::Counts& c) {
             for (auto& k : c) k = static_cast<std::int32_t>((*rng)() % 141) - 70;  // its noise alone
             c[2] += 65333;
             return true;
         };
     },
     {Cause::sensor_open, Cause::residual}},
    {"Frozen",
     [](GuardBench& b) {
         auto held = std::make_shared<std::optional<GuardBench::Counts>>();
         b.sensor = [held](double, GuardBench::Counts& c) {
             if (!*held) *held = c;
             c = **held;
             return true;
         };
     },
     {Cause::sensor_frozen}},
    // The small lobe of a wave may be the first to be clipped, by less than a walker disturbs the base.
    {"ClippedFarBelowTheRange",
     [](GuardBench& b) {
         b.sensor = [](double, GuardBench::Counts& c) {
             constexpr int at = 13067;  // 0.2 g
             for (std::size_t k = 0; k < 2; ++k) c[k] = std::clamp(c[k], -at, at);
             return true;
         };
     },
     {Cause::sensor_saturated, Cause::residual, Cause::sensor_open},
     0.045},
    {"Flipped",
     [](GuardBench& b) {
         b.sensor = [](double, GuardBench::Counts& c) {
             c = {-c[0], -c[1], c[2]};
             return true;
         };
     },
     {Cause::polarity, Cause::residual}},
    // Much of the motion then has the direction of gravity and looks like a change of gravity.
    {"AxesSwapped",
     [](GuardBench& b) {
         b.sensor = [](double, GuardBench::Counts& c) {
             c = {c[2] - 65333, c[1], c[0] + 65333};
             return true;
         };
     },
     {Cause::residual, Cause::transverse, Cause::sensor_open, Cause::gravity},
     0.025},  // half of the motion remains on the second axis
    {"SensorTimesATenth",
     [](GuardBench& b) {
         b.sensor = [](double, GuardBench::Counts& c) {
             c = {c[0] / 10, c[1] / 10, c[2]};
             return true;
         };
     },
     {Cause::sensor_open, Cause::residual}},
    {"GainTimesTen",
     [](GuardBench& b) { b.plant_gain = 10; },
     {Cause::residual, Cause::acceleration, Cause::polarity},
     0.02,
     5},
    // The base itself rings with a time constant of 64 ms.
    {"GainTimesATenth",
     [](GuardBench& b) { b.plant_gain = 0.1; },
     {Cause::sensor_open, Cause::residual, Cause::polarity},
     0.025},
};

class FaultTest : public testing::TestWithParam<Fault> {};

bool one_of(const std::vector<Cause>& causes, Cause cause) {
    return std::ranges::find(causes, cause) != causes.end();
}

/// Time from the fault to the trip, s; the fault begins `after` s of a steady run.
double time_to_trip(const Fault& fault, const Drive& drive, double after) {
    GuardBench bench{{}, test::bench_limits()};
    bench.guard.expect(bench.expectation(drive.frequency));
    bench.synth.set(bench.command(drive, 4));
    bench.run(1 + after);
    EXPECT_TRUE(bench.trips.empty()) << text(bench.trips.at(0));
    const double began = bench.now_s();
    fault.begin(bench);
    bench.run(0.3);
    if (bench.trips.empty()) return INFINITY;
    EXPECT_TRUE(one_of(fault.causes, bench.trips[0].cause)) << text(bench.trips[0]);
    return bench.seconds_of(bench.trips[0]) - began;
}

TEST_P(FaultTest, TripsWithinItsBudgetAtAnyPhaseOfAnyShape) {
    const Fault& fault = GetParam();
    double worst = 0;
    for (const double phi : {0.0, 0.25 * two_pi, 0.5 * two_pi, 0.7 * two_pi})
        for (int k = 0; k < 20; ++k)
            worst = std::max(worst, time_to_trip(fault, {.gamma = fault.gamma, .phi = phi}, 0.0025 * k));
    RecordProperty("worst_ms", std::to_string(1e3 * worst));
    std::printf("%-24s worst of 80 starts %.1f ms\n", fault.name, 1e3 * worst);
    EXPECT_LE(worst, fault.budget_s);
}

// During the soft start the fault is detected as soon as the motion is large enough; smaller motion does no
// harm.
TEST_P(FaultTest, TripsInEveryStateOfTheDrive) {
    const Fault& fault = GetParam();
    const Drive drive{.gamma = fault.gamma}, more{.gamma = 1.2 * fault.gamma, .phi = 1};
    struct State {
        const char* name;
        double before, limit_s;
    };
    for (const State& state : {State{"soft start", 0.2, 0.3}, State{"steady", 0.9, 0.045},
                               State{"set-point change", 1.03, 0.06}, State{"ramp-down", 1.9, 0.1}}) {
        GuardBench bench{{}, test::bench_limits()};
        bench.guard.expect(bench.expectation(20));
        bench.synth.set(bench.command(drive, 10));
        bench.run(std::min(state.before, 1.0));
        if (state.before > 1) {
            bench.synth.set(bench.command(more));
            bench.run(std::min(state.before, 1.8) - 1);
        }
        if (state.before > 1.8) {
            bench.synth.set({.volts = {}, .frequency = 20, .ramp_periods = 10});
            bench.run(state.before - 1.8);
        }
        ASSERT_TRUE(bench.trips.empty()) << state.name << ": " << text(bench.trips[0]);
        const double began = bench.now_s();
        fault.begin(bench);
        bench.run(0.4);
        ASSERT_FALSE(bench.trips.empty()) << state.name;
        EXPECT_LE(bench.seconds_of(bench.trips[0]) - began, state.limit_s) << state.name;
        EXPECT_TRUE(one_of(fault.causes, bench.trips[0].cause)) << state.name << ": " << text(bench.trips[0]);
    }
}

TEST_P(FaultTest, WithItsDetectorsOffItDoesNotTrip) {
    const Fault& fault = GetParam();
    Limits limits = test::bench_limits();
    for (const Cause c : {Cause::residual, Cause::polarity, Cause::sensor_open, Cause::sensor_frozen,
                          Cause::transverse, Cause::gravity})
        limits.detectors.reset(static_cast<std::size_t>(c));
    limits.acceleration = limits.velocity = limits.displacement = {};
    limits.sensor_range_mps2 = INFINITY;
    limits.detectors.reset(static_cast<std::size_t>(Cause::sensor_saturated));
    GuardBench bench{{}, limits};
    bench.guard.expect(bench.expectation(20));
    bench.synth.set(bench.command({.gamma = fault.gamma}));
    bench.run(1);
    fault.begin(bench);
    bench.run(0.5);
    for (const Trip& t : bench.trips) ADD_FAILURE() << text(t);
}
INSTANTIATE_TEST_SUITE_P(Faults, FaultTest, testing::ValuesIn(faults),
                         [](const auto& of) { return std::string{of.param.name}; });

TEST(SampleGuardResidualTest, ChecksNothingWithoutExpectation) {
    Limits limits = test::bench_limits();
    limits.transverse = {};
    GuardBench bench{{}, limits};
    bench.synth.set(bench.command({}));
    bench.run(1);
    bench.plant_gain = 0.1;
    bench.run(1);
    EXPECT_TRUE(bench.trips.empty());
}

// The sliding friction of a walker is a square wave of mu m_w g / M in the rhythm of the drive: 0.4 m/s^2
// for 120 g on 0.33 kg at mu = 0.113. It comes and goes at once when a hand puts the walker down.
double walker(double t) { return std::fmod(t, 3) < 1.5 ? (std::fmod(20 * t, 1) < 0.5 ? 0.4 : -0.4) : 0; }

struct Course {
    double least_gamma, frequency_spread;
};
class NormalDriving : public testing::TestWithParam<Course> {};

TEST_P(NormalDriving, FiveMillionSamplesDoNotTrip) {
    GuardBench bench{{.seed = 11}, test::bench_limits()};
    bench.disturbance = walker;
    std::mt19937_64 rng{5};
    std::uniform_real_distribution<double> unit{0, 1};
    double frequency = 20;
    bench.guard.expect(bench.expectation(frequency));
    const auto [least, spread] = GetParam();
    while (bench.samples < 5'000'000 && bench.trips.empty()) {
        if (spread > 0 && unit(rng) < 0.3) {
            frequency = 20 + spread * (2 * unit(rng) - 1);
            bench.guard.expect(bench.expectation(frequency));
        }
        const Drive drive{frequency, (least + 1.5 * unit(rng)) * paper_g, unit(rng), two_pi * unit(rng)};
        DriveCommand c = bench.command(drive, 1 + static_cast<int>(10 * unit(rng) * unit(rng)));
        if (unit(rng) < 0.1) c.volts = {};
        bench.synth.set(c);
        bench.run(0.3 + 2 * unit(rng));
    }
    for (const Trip& t : bench.trips)
        ADD_FAILURE() << text(t) << " at " << bench.now_s() << " s of " << frequency << " Hz";
    EXPECT_EQ(bench.synth.clamped(), 0U);
}
INSTANTIATE_TEST_SUITE_P(Courses, NormalDriving, testing::Values(Course{0.3, 0}, Course{0.3, 8}),
                         [](const auto& of) {
                             return std::string{of.param.frequency_spread > 0 ? "OfManyFrequencies"
                                                                              : "OfOneFrequency"};
                         });

}  // namespace
}  // namespace shaker::safety

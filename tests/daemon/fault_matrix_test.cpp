// Every fault of drive and sensors, begun in every state of a run: none goes without a trip, and the drive is
// silent in time. In virtual time.
#include <gtest/gtest.h>

#include <cstdio>

#include "tests/support/virtual_run.hpp"

namespace shaker {
namespace {

using test::run_virtually;
using test::VirtualRun;

const std::string bench = "[accelerometer]\naxis_told = 1\nblock_samples = 10\n";

// When a run without a fault enters its states.
const VirtualRun& healthy() {
    static const VirtualRun run = run_virtually({.scene = bench});
    return run;
}

struct Fault {
    const char* name;
    const char* toml;      // of the [[fault]], without its time
    double silent_within;  // s from the fault, or from the beginning of the state that can show it
    RunState shows_from;   // the first state in which it can be seen at all
};

const Fault faults[] = {
    {"open", "what = \"open\"", 0.3, RunState::identify},
    {"frozen", "what = \"frozen\"", 0.4, RunState::identify},
    {"saturated", "what = \"saturated\"", 0.1, RunState::self_test},
    {"silent", "what = \"silent\"\nfor_s = 100", 0.1, RunState::self_test},
    {"flipped", "what = \"flipped\"", 4, RunState::identify},
    {"swapped", "what = \"swapped\"", 4, RunState::identify},
    {"gain_small", "what = \"gain\"\nvalue = 0.1", 11, RunState::identify},
    {"gain_large", "what = \"gain\"\nvalue = 10", 4, RunState::identify},
    {"plant_large", "what = \"amplifier_gain\"\nvalue = 10", 4, RunState::identify},
    {"plant_small", "what = \"amplifier_gain\"\nvalue = 0.1", 11, RunState::identify},
    {"plant_flipped", "what = \"amplifier_gain\"\nvalue = -1", 4, RunState::identify},
};
const RunState states[] = {RunState::self_test, RunState::identify, RunState::ramp, RunState::run};

class FaultMatrixTest : public ::testing::TestWithParam<std::tuple<Fault, RunState>> {};

TEST_P(FaultMatrixTest, Trips) {
    const auto& [fault, state] = GetParam();
    const double at_s = healthy().entered_s.at(state) + 0.4;
    const VirtualRun run = run_virtually(
        {.scene = bench + "[[fault]]\nat_s = " + std::to_string(at_s) + "\n" + fault.toml + "\n"});
    ASSERT_EQ(run.ended, RunState::tripped) << "no trip";
    ASSERT_TRUE(run.trip);
    const double shows_s = std::max(
        at_s, run.entered_s.contains(fault.shows_from) ? healthy().entered_s.at(fault.shows_from) : at_s);
    std::printf("%s in %s: %s; silent %.0f ms after\n", fault.name, name(state), text(*run.trip).c_str(),
                1e3 * (run.silent_s - shows_s));
    EXPECT_LT(run.silent_s, shows_s + fault.silent_within);
    EXPECT_LE(run.largest_V, 0.951);  // the limit
}

INSTANTIATE_TEST_SUITE_P(All, FaultMatrixTest,
                         ::testing::Combine(::testing::ValuesIn(faults), ::testing::ValuesIn(states)),
                         [](const auto& from) {
                             return std::string{std::get<0>(from.param).name} + "_in_" +
                                    name(std::get<1>(from.param));
                         });

TEST(VirtualRunTest, AHealthyRunGoesThroughItsStatesWithoutATrip) {
    const VirtualRun& run = healthy();
    EXPECT_EQ(run.ended, RunState::idle);
    EXPECT_FALSE(run.trip) << text(*run.trip);
    double before = -1;
    for (const RunState s : {RunState::init, RunState::self_test, RunState::identify, RunState::ramp,
                             RunState::run, RunState::ramp_down}) {
        ASSERT_TRUE(run.entered_s.contains(s)) << name(s);
        EXPECT_GT(run.entered_s.at(s), before) << name(s);
        before = run.entered_s.at(s);
    }
}

}  // namespace
}  // namespace shaker

// Every fault of drive and sensors in every state of a run: it trips with the right cause, and the drive is
// silent in time. Virtual time. One seed of the noise and of the time of the fault; nightly 2;
// tests/bench/run trips tries more.
#include <gtest/gtest.h>

#include "tests/support/nightly.hpp"
#include "tests/support/safety/fault_cases.hpp"

namespace shaker::safety {
namespace {

using test::FaultCase;
using test::run_virtually;
using test::VirtualRun;

int seeds() { return test::nightly() ? 2 : 1; }

class FaultMatrixTest : public ::testing::TestWithParam<std::tuple<FaultCase, run::RunState>> {};

TEST_P(FaultMatrixTest, TripsByTheRightCauseInTime) {
    const auto& [fault, state] = GetParam();
    for (int seed = 1; seed <= seeds(); ++seed)
        EXPECT_EQ(test::complaint(fault, state, test::inject(fault, state, seed)), "") << "seed " << seed;
}

INSTANTIATE_TEST_SUITE_P(All, FaultMatrixTest,
                         ::testing::Combine(::testing::ValuesIn(test::fault_cases()),
                                            ::testing::ValuesIn(test::lasting_states)),
                         [](const auto& from) {
                             return std::get<0>(from.param).name + "_in_" + name(std::get<1>(from.param));
                         });

INSTANTIATE_TEST_SUITE_P(OneAxis, FaultMatrixTest,
                         ::testing::Combine(::testing::ValuesIn(test::one_axis_cases()),
                                            ::testing::ValuesIn(test::lasting_states)),
                         [](const auto& from) {
                             return std::get<0>(from.param).name + "_in_" + name(std::get<1>(from.param));
                         });

TEST(TripTimeTest, ExceededLimitRampsDriveWithinBlockAndOneMs) {
    for (int seed = 1; seed <= 12; ++seed) {
        const test::Crossing crossing = test::cross_limit(seed);
        EXPECT_LE(crossing.to_ramp_s, test::limit_to_ramp_s) << "seed " << seed;
        EXPECT_LE(crossing.to_silence_s, test::limit_to_silence_s) << "seed " << seed;
    }
}

// For all positions of the last good sample in the output's block.
TEST(TripTimeTest, LostOrFrozenSensorIsSilentWithin80Ms) {
    for (const FaultCase& fault : test::fault_cases()) {
        if (fault.name != "silent" && fault.name != "frozen") continue;
        for (int seed = 1; seed <= 12; ++seed)
            EXPECT_LE(test::inject(fault, run::RunState::run, seed).to_silence_s(), 0.08)
                << fault.name << seed;
    }
}

TEST(VirtualRunTest, HealthyRunPassesItsStatesWithoutTrip) {
    const VirtualRun run = run_virtually({.scene = "[accelerometer]\naxis_told = 1\n"});
    EXPECT_EQ(run.ended, run::RunState::idle);
    EXPECT_FALSE(run.trip) << text(*run.trip);
    double before = -1;
    for (const run::RunState s : test::lasting_states) {
        ASSERT_TRUE(run.entered_s.contains(s)) << name(s);
        EXPECT_GT(run.entered_s.at(s), before) << name(s);
        before = run.entered_s.at(s);
    }
}

}  // namespace
}  // namespace shaker::safety

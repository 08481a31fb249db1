// No drive before the self-test at rest was passed, whatever stopped it.
#include <gtest/gtest.h>

#include "tests/support/run/bench_on_call.hpp"

namespace shaker::service {
namespace {

using run::RunState;
using test::entered;
using test::fault;
using test::from_s;
using test::in;
using test::may_clear;
using test::until;

constexpr double self_test_s = 0.6;

using SelfTestedTest = test::OnCallBench;

// SAFE-19
TEST_F(SelfTestedTest, WrongGravityIsFoundAgainAfterAClear) {
    const auto r =
        play(test::slow + fault("gain", 0, "value = 0.5\n"),
             {{may_clear, give(ClearTrip{})}, until(in(RunState::self_test)), until(may_clear)}, 10);
    EXPECT_EQ(r.last.state, RunState::tripped);
    ASSERT_TRUE(r.last.trip);
    EXPECT_EQ(r.last.trip->cause, safety::Cause::gravity);
    EXPECT_TRUE(entered(r, RunState::idle).empty()) << test::log_of(r);
}

// The step of the reading that the repair makes dies away before the clear.
TEST_F(SelfTestedTest, SensorThatWasSetRightPasses) {
    const auto r = play(test::slow + fault("gain", 0, "for_s = 0.3\nvalue = 0.5\n"),
                        {{[](const BenchState& s) { return s.may_clear && s.now_s > 25; }, give(ClearTrip{})},
                         start(),
                         until(in(RunState::run))},
                        45);
    ASSERT_EQ(answers, test::Answers(2, "")) << test::log_of(r);
    for (const BenchEvent& e : r.events)
        EXPECT_EQ(e.text.find("the base answers"), std::string::npos) << e.text;
}

// SAFE-19
TEST_F(SelfTestedTest, AbortBeforeItsEndDoesNotSkipIt) {
    for (const RunState state : {RunState::init, RunState::self_test}) {
        SCOPED_TRACE(name(state));
        const auto r = play(test::slow,
                            {{in(state), [](BenchPort& port) { port.abort("a test"); }},
                             {may_clear, give(ClearTrip{})},
                             start(),
                             until(in(RunState::run))},
                            20);
        EXPECT_EQ(answers, test::Answers(2, ""));
        const std::vector<double> tested = entered(r, RunState::self_test), idle = entered(r, RunState::idle);
        ASSERT_FALSE(tested.empty()) << test::log_of(r);
        ASSERT_FALSE(idle.empty());
        EXPECT_GE(idle[0], tested.back() + self_test_s - 1e-9) << test::log_of(r);
        EXPECT_GT(tested.back(), entered(r, RunState::tripped).at(0));
    }
}

TEST_F(SelfTestedTest, PassedSelfTestIsNotRepeated) {
    const auto r = play(test::slow,
                        {{in(RunState::idle), [](BenchPort& port) { port.abort("a test"); }},
                         {may_clear, give(ClearTrip{})},
                         until(in(RunState::idle))},
                        10);
    EXPECT_EQ(entered(r, RunState::self_test).size(), 1U) << test::log_of(r);
}

// SAFE-19. A period is longer than the silence.
TEST_F(SelfTestedTest, SlowDriveWaitsForAWindow) {
    options.drive = {.frequency = 1, .gamma = 0.02};
    const auto r = play(test::slow + fault("gain", 0, "value = 0.5\n"), {until(from_s(4))}, 10);
    EXPECT_EQ(r.last.state, RunState::tripped) << test::log_of(r);
    EXPECT_TRUE(entered(r, RunState::idle).empty()) << test::log_of(r);
}

}  // namespace
}  // namespace shaker::service

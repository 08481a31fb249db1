// Orders, aborts and trips of a bench on call that come close together.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/run/bench_on_call.hpp"

namespace shaker::service {
namespace {

using run::RunState;
using test::Answers;
using test::entered;
using test::fault;
using test::from_s;
using test::in;
using test::may_clear;
using test::slow;
using test::until;

using AbortTest = test::OnCallBench;

TEST_F(AbortTest, AbortAfterUnderrunWithTripIsFinal) {
    const auto r = play(
        slow + fault("underrun", 9, "value = 480\n") + fault("flipped", 9.05, "for_s = 0.05\n"),
        {start(), {in(RunState::tripped), [](BenchPort& port) { port.abort("a test"); }}, until(from_s(14))});
    EXPECT_EQ(r.last.state, RunState::tripped);
    const std::vector<double> tripped = entered(r, RunState::tripped);
    ASSERT_EQ(tripped.size(), 1U);
    EXPECT_LT(tripped[0], 9.5);
    for (const RunState driven : {RunState::ramp, RunState::run, RunState::identify})
        for (const double t : entered(r, driven)) EXPECT_LT(t, tripped[0]) << name(driven);
    EXPECT_EQ(r.last.trips, 2U) << "the cause and the abort";
}

TEST_F(AbortTest, TripBesideUnderrunWaitsForTheOperator) {
    const auto r =
        play(slow + fault("underrun", 9, "value = 480\n") + fault("flipped", 9.05, "for_s = 0.05\n"),
             {start(), until(from_s(14))});
    EXPECT_EQ(r.last.state, RunState::tripped);
}

TEST_F(AbortTest, UnderrunAloneComesBackSoftly) {
    options.drive.phi = 1.75;  // a slow walk
    const auto r = play(slow + fault("underrun", 9, "value = 480\n"),
                        {start(), {from_s(14), give(End{})}, until(from_s(16))});
    EXPECT_EQ(r.last.trips, 0U) << (r.last.trip ? text(*r.last.trip) : "");
    const std::vector<double> ran = entered(r, RunState::run);
    ASSERT_EQ(ran.size(), 2U);
    EXPECT_GT(ran[1], 9.4) << "after the soft start";
}

TEST_F(AbortTest, OrdersFromBeforeTheAbortAreRefused) {
    Drive other;
    other.gamma = 5;
    const auto r = play(slow, {{in(RunState::idle),
                                [&](BenchPort& port) {
                                    give(SetDrive{other})(port);
                                    give(Begin{10})(port);
                                    give(Remark{"the lamp flickers"})(port);
                                    port.abort("a test");
                                }},
                               {in(RunState::tripped),
                                [&](BenchPort& port) {
                                    give(ClearTrip{})(port);
                                    give(Begin{10})(port);
                                    port.abort("a test");
                                }},
                               until(from_s(3))});
    ASSERT_EQ(answers.size(), 5U);
    for (const std::size_t i : {0U, 1U, 3U, 4U})
        EXPECT_NE(answers[i].find("an abort came after this order"), std::string::npos) << answers[i];
    EXPECT_EQ(answers[2], "") << "a remark cannot drive the shaker";
    EXPECT_EQ(r.last.state, RunState::tripped) << "an abort at rest leaves a trip";
    EXPECT_EQ(r.last.wanted.gamma, paper_g);
}

TEST_F(AbortTest, ClearFromBeforeTheTripIsRefused) {
    const auto r =
        play(slow + fault("flipped", 5, "for_s = 0.05\n"), {start(),
                                                            {may_clear, give(ClearTrip{.shown = 0})},
                                                            {may_clear, give(ClearTrip{})},
                                                            until(in(RunState::idle))});
    ASSERT_EQ(answers.size(), 3U);
    EXPECT_EQ(answers[1], "a trip came after this clear; look at its cause, then clear it");
    EXPECT_EQ(answers[2], "");
}

TEST_F(AbortTest, SoftStopEndsWithinTwoSecondsAtOneHertz) {
    options.drive.frequency = 1;
    options.drive.gamma = 0.02;
    options.identify = false;
    for (const RunState from : {RunState::ramp, RunState::run}) {
        double asked_s = NAN;
        const auto r = play(slow, {start(),
                                   {in(from),
                                    [&](BenchPort& port) {
                                        asked_s = port.state()->now_s;
                                        give(End{})(port);
                                    }},
                                   until(in(RunState::idle))});
        EXPECT_EQ(answers, Answers(2, "")) << name(from);
        const std::vector<double> idle = entered(r, RunState::idle);
        ASSERT_EQ(idle.size(), 2U) << name(from);
        EXPECT_LT(idle[1] - asked_s, 2.1) << name(from);
    }
}

}  // namespace
}  // namespace shaker::service

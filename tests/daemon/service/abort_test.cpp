// Orders, aborts and trips of a bench on call that come close together.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/program.hpp"
#include "tests/support/run/bench_on_call.hpp"

namespace shaker::service {
namespace {

using run::RunState;
using test::Answers;
using test::in;
using test::orders;
using test::play_on_call;
using test::quick;
using test::slow;

auto from_s(double t) {
    return [t](const BenchState& s) { return s.now_s >= t; };
}

std::string fault(const char* what, double at_s, const char* more = "") {
    return "[[fault]]\nwhat = \"" + std::string{what} + "\"\nat_s = " + std::to_string(at_s) + "\n" + more;
}

// Times at which the bench entered a state.
std::vector<double> entered(const test::OnCallResult& r, RunState state) {
    std::vector<double> times;
    for (const BenchEvent& e : r.events)
        if (e.kind == "state" && e.text == name(state)) times.push_back(e.t_s);
    return times;
}

TEST(AbortTest, AbortAfterUnderrunWithTripIsFinal) {
    Answers answers;
    const auto r =
        play_on_call(slow + fault("underrun", 9, "value = 480\n") + fault("flipped", 9.05, "for_s = 0.05\n"),
                     quick(), test::fresh_folder(),
                     {{in(RunState::idle), orders(Begin{10}, answers)},
                      {in(RunState::tripped), [](BenchPort& port) { port.abort("a test"); }},
                      {from_s(14), [](BenchPort&) {}}});
    EXPECT_EQ(r.last.state, RunState::tripped);
    const std::vector<double> tripped = entered(r, RunState::tripped);
    ASSERT_EQ(tripped.size(), 1U);
    EXPECT_LT(tripped[0], 9.5);
    for (const RunState driven : {RunState::ramp, RunState::run, RunState::identify})
        for (const double t : entered(r, driven)) EXPECT_LT(t, tripped[0]) << name(driven);
    EXPECT_EQ(r.last.trips, 2U) << "the cause and the abort";
}

TEST(AbortTest, TripBesideUnderrunWaitsForTheOperator) {
    Answers answers;
    const auto r =
        play_on_call(slow + fault("underrun", 9, "value = 480\n") + fault("flipped", 9.05, "for_s = 0.05\n"),
                     quick(), test::fresh_folder(),
                     {{in(RunState::idle), orders(Begin{10}, answers)}, {from_s(14), [](BenchPort&) {}}});
    EXPECT_EQ(r.last.state, RunState::tripped);
}

TEST(AbortTest, UnderrunAloneComesBackSoftly) {
    Answers answers;
    run::RunOptions run = quick();
    run.drive.phi = 1.75;  // a slow walk
    const auto r = play_on_call(slow + fault("underrun", 9, "value = 480\n"), run, test::fresh_folder(),
                                {{in(RunState::idle), orders(Begin{10}, answers)},
                                 {from_s(14), orders(End{}, answers)},
                                 {from_s(16), [](BenchPort&) {}}});
    EXPECT_EQ(r.last.trips, 0U) << (r.last.trip ? text(*r.last.trip) : "");
    const std::vector<double> ran = entered(r, RunState::run);
    ASSERT_EQ(ran.size(), 2U);
    EXPECT_GT(ran[1], 9.4) << "after the soft start";
}

TEST(AbortTest, OrdersFromBeforeTheAbortAreRefused) {
    Answers answers;
    Drive other;
    other.gamma = 5;
    const auto r = play_on_call(slow, quick(), test::fresh_folder(),
                                {{in(RunState::idle),
                                  [&](BenchPort& port) {
                                      orders(SetDrive{other}, answers)(port);
                                      orders(Begin{10}, answers)(port);
                                      orders(Remark{"the lamp flickers"}, answers)(port);
                                      port.abort("a test");
                                  }},
                                 {in(RunState::tripped),
                                  [&](BenchPort& port) {
                                      orders(ClearTrip{}, answers)(port);
                                      orders(Begin{10}, answers)(port);
                                      port.abort("a test");
                                  }},
                                 {from_s(3), [](BenchPort&) {}}});
    ASSERT_EQ(answers.size(), 5U);
    for (const std::size_t i : {0U, 1U, 3U, 4U})
        EXPECT_NE(answers[i].find("an abort came after this order"), std::string::npos) << answers[i];
    EXPECT_EQ(answers[2], "") << "a remark cannot drive the shaker";
    EXPECT_EQ(r.last.state, RunState::tripped) << "an abort at rest leaves a trip";
    EXPECT_EQ(r.last.wanted.gamma, paper_g);
}

TEST(AbortTest, ClearFromBeforeTheTripIsRefused) {
    Answers answers;
    const auto clearable = [](const BenchState& s) { return s.may_clear; };
    const auto r = play_on_call(slow + fault("flipped", 5, "for_s = 0.05\n"), quick(), test::fresh_folder(),
                                {{in(RunState::idle), orders(Begin{10}, answers)},
                                 {clearable, orders(ClearTrip{.shown = 0}, answers)},
                                 {clearable, orders(ClearTrip{}, answers)},
                                 {in(RunState::idle), [](BenchPort&) {}}});
    ASSERT_EQ(answers.size(), 3U);
    EXPECT_EQ(answers[1], "a trip came after this clear; look at its cause, then clear it");
    EXPECT_EQ(answers[2], "");
}

TEST(AbortTest, SoftStopEndsWithinTwoSecondsAtOneHertz) {
    run::RunOptions run = quick();
    run.drive.frequency = 1;
    run.drive.gamma = 0.02;
    run.identify = false;
    for (const RunState from : {RunState::ramp, RunState::run}) {
        Answers answers;
        double asked_s = NAN;
        const auto r = play_on_call(slow, run, test::fresh_folder(),
                                    {{in(RunState::idle), orders(Begin{10}, answers)},
                                     {in(from),
                                      [&](BenchPort& port) {
                                          asked_s = port.state()->now_s;
                                          orders(End{}, answers)(port);
                                      }},
                                     {in(RunState::idle), [](BenchPort&) {}}});
        EXPECT_EQ(answers, Answers(2, "")) << name(from);
        const std::vector<double> idle = entered(r, RunState::idle);
        ASSERT_EQ(idle.size(), 2U) << name(from);
        EXPECT_LT(idle[1] - asked_s, 2.1) << name(from);
    }
}

}  // namespace
}  // namespace shaker::service

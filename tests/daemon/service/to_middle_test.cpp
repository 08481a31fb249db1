// The order that brings the walker to the middle of the picture, and the friction coefficient by an order.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "tests/support/run/bench_on_call.hpp"

namespace shaker::service {
namespace {

using run::RunState;
using test::Answers;
using test::in;
using test::may_clear;
using test::until;

constexpr calibration::Estimate not_known{NAN, NAN};

std::string walker_at(const char* start_mm, const char* before = "", const char* more = "") {
    std::string scene = before;
    scene += test::slow;
    scene += "[walker]\nstart_mm = ";
    scene += start_mm;
    scene += "\n";
    return scene += more;
}

double off_middle_mm(const BenchState& s) {
    return s.walker ? 1e3 * std::abs(s.walker->x_m - (s.walker->left_m + s.walker->right_m) / 2) : NAN;
}

bool logged(const test::OnCallResult& r, const char* words) {
    return std::ranges::any_of(r.events,
                               [&](const BenchEvent& e) { return e.text.find(words) != std::string::npos; });
}

bool on_its_way(const BenchState& s) { return s.to_middle && s.state == RunState::run; }
bool back_at_rest(const BenchState& s) { return !s.to_middle && s.state == RunState::idle; }

class ToMiddleTest : public test::OnCallBench {};

// The walker has tripped at the edge before anything was measured, and its friction is not known.
TEST_F(ToMiddleTest, LeadsOutOfTheFirstTripAtTheEdge) {
    const auto r = play(walker_at("40"),
                        {start(),
                         {may_clear, give(ClearTrip{})},
                         start(),
                         {in(RunState::idle), give(BringToMiddle{})},
                         until(on_its_way),
                         until(back_at_rest),
                         start(),
                         until(test::measured(1))},
                        60, not_known);
    ASSERT_EQ(answers.size(), 5U) << test::log_of(r);
    EXPECT_EQ(answers[0] + answers[1] + answers[3] + answers[4], "");
    EXPECT_NE(answers[2].find("bring it to the middle first"), std::string::npos) << answers[2];
    EXPECT_EQ(r.last.trips, 1U) << test::log_of(r);
    EXPECT_TRUE(logged(r, "mm from the middle")) << test::log_of(r);
    EXPECT_EQ(r.last.wanted.phi, options.drive.phi) << "the set-point stays";
}

TEST_F(ToMiddleTest, ComesToRestInTheMiddleFromBothSides) {
    for (const char* start_mm : {"-44", "44", "30", "-25"}) {
        const auto r =
            play(walker_at(start_mm),
                 {{in(RunState::idle), give(BringToMiddle{})}, until(on_its_way), until(back_at_rest)}, 60,
                 {0.113, 0.001});
        EXPECT_EQ(answers, Answers(1, "")) << start_mm;
        EXPECT_EQ(r.last.trips, 0U) << start_mm << '\n' << test::log_of(r);
        EXPECT_TRUE(r.last.points.empty()) << "a return measures nothing";
        EXPECT_LT(off_middle_mm(r.last), 4) << start_mm << '\n' << test::log_of(r);
    }
}

TEST_F(ToMiddleTest, RefusalsSayWhatToDo) {
    Drive other;
    other.phi = 1;
    play(walker_at("0.2"),
         {{in(RunState::idle), give(BringToMiddle{})},
          start(),
          {in(RunState::run), give(BringToMiddle{})},
          {test::measured(1), give(End{})},
          until(in(RunState::idle))},
         60, {0.113, 0.001});
    ASSERT_EQ(answers.size(), 4U);
    EXPECT_NE(answers[0].find("mm from the middle already"), std::string::npos) << answers[0];
    EXPECT_NE(answers[2].find("bringing the walker to the middle cannot start"), std::string::npos)
        << answers[2];
    play(walker_at("30"),
         {{in(RunState::idle), give(BringToMiddle{})},
          {on_its_way, give(SetDrive{other})},
          {on_its_way, give(Begin{10})},
          until(back_at_rest)},
         60, {0.113, 0.001});
    ASSERT_EQ(answers.size(), 3U);
    EXPECT_NE(answers[1].find("is being brought to the middle"), std::string::npos) << answers[1];
    EXPECT_NE(answers[2].find("cannot start"), std::string::npos) << answers[2];
}

TEST_F(ToMiddleTest, AbortAndStopEndIt) {
    const auto aborted = play(walker_at("30"),
                              {{in(RunState::idle), give(BringToMiddle{})},
                               {on_its_way, [](BenchPort& port) { port.abort("test"); }},
                               until(may_clear)},
                              30, {0.113, 0.001});
    EXPECT_EQ(aborted.last.state, RunState::tripped);
    EXPECT_FALSE(aborted.last.to_middle);
    const auto stopped =
        play(walker_at("30"),
             {{in(RunState::idle), give(BringToMiddle{})}, {on_its_way, give(End{})}, until(back_at_rest)},
             30, {0.113, 0.001});
    EXPECT_EQ(answers, Answers(2, ""));
    EXPECT_GT(off_middle_mm(stopped.last), 20);
}

// Outside the limit the permit of the edge guards the return; inside, the return itself.
TEST_F(ToMiddleTest, WalkerThatDoesNotComeIsGivenUp) {
    const auto outside =
        play(walker_at("45", "", "mu_k = 2\n"),
             {{in(RunState::idle), give(BringToMiddle{})}, until(in(RunState::tripped))}, 30, not_known);
    EXPECT_EQ(answers, Answers(1, ""));
    ASSERT_TRUE(outside.last.trip);
    EXPECT_EQ(outside.last.trip->cause, safety::Cause::walker_edge);
    const auto inside = play(
        walker_at("30", "", "mu_k = 2\n"),
        {{in(RunState::idle), give(BringToMiddle{})}, until(on_its_way), until(back_at_rest)}, 90, not_known);
    EXPECT_EQ(inside.last.trips, 0U);
    EXPECT_TRUE(logged(inside, "the walker does not move to the middle")) << test::log_of(inside);
}

TEST_F(ToMiddleTest, WalkAwayFromTheMiddleStops) {
    const auto r = play(walker_at("30", "tilt_deg = 3\n"),
                        {{in(RunState::idle), give(BringToMiddle{})}, until(on_its_way), until(back_at_rest)},
                        60, {0.113, 0.001});
    EXPECT_EQ(r.last.trips, 0U) << test::log_of(r);
    EXPECT_TRUE(logged(r, "it went away from the middle")) << test::log_of(r);
}

// After a trip at the edge; while something is driven or tripped it is refused.
TEST_F(ToMiddleTest, SimulatedWalkerIsPutBackAtRest) {
    const auto in_the_middle = [](const BenchState& s) {
        return s.state == RunState::idle && off_middle_mm(s) < 0.5;
    };
    const auto r = play(walker_at("40"),
                        {start(),
                         {in(RunState::run), give(PutWalkerBack{})},
                         {may_clear, give(PutWalkerBack{})},
                         {may_clear, give(ClearTrip{})},
                         {in(RunState::idle), give(PutWalkerBack{})},
                         until(in_the_middle),
                         start(),
                         until(test::measured(1))},
                        60, not_known);
    ASSERT_EQ(answers.size(), 6U) << test::log_of(r);
    EXPECT_NE(answers[1].find("while the bench is running"), std::string::npos) << answers[1];
    EXPECT_NE(answers[2].find("clear the trip first"), std::string::npos) << answers[2];
    EXPECT_EQ(answers[3] + answers[4] + answers[5], "");
    EXPECT_TRUE(logged(r, "the simulated walker is put back")) << test::log_of(r);
    EXPECT_EQ(r.last.trips, 1U) << test::log_of(r);
    EXPECT_TRUE(r.last.facts->simulated);
}

// The pictures of the moment stay until the trip is cleared.
TEST_F(ToMiddleTest, PicturesOfTripStayUntilItIsCleared) {
    double at_trip_s = NAN, later_s = NAN, newest_s = NAN;
    const auto look = [&](double& at_s) {
        return [&at_s, &newest_s](const BenchState& s) {
            if (s.state != RunState::tripped || s.trip_pictures.empty()) return false;
            at_s = s.trip_pictures.front().t_s;
            newest_s = s.pictures_now.front().t_s;
            return true;
        };
    };
    const auto r = play(walker_at("30"),
                        {start(),
                         {in(RunState::run), [](BenchPort& port) { port.abort("test"); }},
                         until(look(at_trip_s)),
                         {may_clear, [](BenchPort&) {}},
                         until(look(later_s)),
                         {may_clear, give(ClearTrip{})},
                         until(in(RunState::idle))},
                        30, {0.113, 0.001});
    EXPECT_EQ(at_trip_s, later_s);
    EXPECT_LT(later_s, newest_s);
    EXPECT_NEAR(at_trip_s, entered(r, RunState::tripped).at(0), 0.1);
    EXPECT_TRUE(r.last.trip_pictures.empty()) << "cleared";
}

TEST_F(ToMiddleTest, GivenFrictionPredictsWalksAndIsChecked) {
    const auto r = play(walker_at("45"),
                        {start(),
                         {in(RunState::idle), give(GiveMu{{7, 0}})},
                         {in(RunState::idle), give(GiveMu{{0.113, 0.001}})},
                         start()},
                        10, not_known);
    ASSERT_EQ(answers.size(), 4U);
    EXPECT_NE(answers[0].find("its direction cannot be predicted: give mu"), std::string::npos) << answers[0];
    EXPECT_NE(answers[1].find("mu 7: 0.005 to 3 is allowed"), std::string::npos) << answers[1];
    EXPECT_EQ(answers[2], "");
    EXPECT_NE(answers[3].find("does not lead inwards"), std::string::npos) << answers[3];
    EXPECT_DOUBLE_EQ(r.last.mu.value, 0.113);
}

}  // namespace
}  // namespace shaker::service

// The way back from a trip at the edge of the picture.
#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>
#include <string>

#include "tests/support/run/bench_on_call.hpp"

namespace shaker::service {
namespace {

using run::RunState;
using test::Answers;
using test::in;
using test::may_clear;
using test::until;

Drive turned_back() {
    Drive drive;
    drive.phi = std::numbers::pi;
    return drive;
}

// The walker starts near the edge. before, after: TOML before and after the tables of cameras and walker.
std::string near_the_edge(const std::string& before = "", const std::string& after = "",
                          const char* start_mm = "40") {
    std::string scene = before;
    scene += test::slow;
    scene += "[walker]\nstart_mm = ";
    scene += start_mm;
    scene += "\n";
    return scene += after;
}

class EdgeTest : public test::OnCallBench {
protected:
    // Drives the walker to the edge, clears the trip, and gives these moves. Their answers remain.
    test::OnCallResult after_the_edge(const std::string& scene, std::vector<test::Move> moves,
                                      calibration::Estimate mu) {
        std::vector<test::Move> all{start(), {may_clear, give(ClearTrip{})}};
        std::ranges::move(moves, std::back_inserter(all));
        test::OnCallResult result = play(scene, all, 60, mu);
        if (answers.size() >= 2) answers.erase(answers.begin(), answers.begin() + 2);
        return result;
    }
};

TEST_F(EdgeTest, DriveInwardsLeavesTheEdge) {
    const auto r = after_the_edge(
        near_the_edge(),
        {start(),
         {in(RunState::idle), give(SetDrive{turned_back()})},
         start(),
         {[](const BenchState& s) { return s.state == RunState::run && s.walker->edge_m > 0.008; },
          give(End{})},
         until(in(RunState::idle))},
        {0.113, 0.001});
    ASSERT_EQ(answers.size(), 4U);
    EXPECT_NE(answers[0].find("does not lead inwards"), std::string::npos) << answers[0];
    EXPECT_EQ(answers[2], "");
    EXPECT_EQ(r.last.trips, 1U) << "the one at the edge";
    EXPECT_TRUE(std::ranges::any_of(r.events, [](const BenchEvent& e) {
        return e.text.find("about 118 periods until the edge limit") != std::string::npos;
    }));
}

TEST_F(EdgeTest, UnknownWalkIsRefused) {
    Drive other = turned_back();
    other.gamma = 5;
    after_the_edge(near_the_edge(), {{in(RunState::idle), give(SetDrive{other})}, start()}, {NAN, NAN});
    ASSERT_EQ(answers.size(), 2U);
    EXPECT_NE(answers[1].find("its direction cannot be predicted: give mu"), std::string::npos) << answers[1];
}

void expect_trip_within_half_a_millimetre(const test::OnCallResult& r) {
    ASSERT_TRUE(r.last.trip);
    EXPECT_EQ(r.last.trip->cause, safety::Cause::walker_edge);
    EXPECT_EQ(r.last.trips, 2U) << test::log_of(r);
    EXPECT_GT(r.last.trip->value, r.last.trip->limit - 0.2) << "mm";
}

// The table is tilted by more than the walk can climb: the prediction is wrong.
TEST_F(EdgeTest, WalkAgainstThePredictionTripsAtOnce) {
    const auto r = after_the_edge(
        near_the_edge("tilt_deg = 3\n"),
        {{in(RunState::idle), give(SetDrive{turned_back()})}, start(), until(in(RunState::tripped))},
        {0.113, 0.001});
    EXPECT_EQ(answers, Answers(2, ""));
    expect_trip_within_half_a_millimetre(r);
}

// The sensor is mounted the other way round than the cameras' direction says.
// Both harmonics show it before the walker goes.
TEST_F(EdgeTest, CameraDirectionToldWrongTripsBeforeItWalks) {
    const auto r = after_the_edge(near_the_edge("", "[accelerometer]\nyaw_deg = -178\n", "-40"),
                                  {start(), until(in(RunState::tripped))}, {0.113, 0.001});
    EXPECT_EQ(answers, Answers(1, ""));
    ASSERT_TRUE(r.last.trip);
    EXPECT_EQ(r.last.trip->cause, safety::Cause::polarity) << test::log_of(r);
}

// The walker sticks: its friction is not that of the settings.
TEST_F(EdgeTest, StandingWalkerTripsAfterTwentyPeriods) {
    const auto r =
        play(near_the_edge("", "mu_k = 2\n", "45"),
             {{in(RunState::idle), give(SetDrive{turned_back()})}, start(), until(in(RunState::tripped))}, 60,
             {0.113, 0.001});
    EXPECT_EQ(answers, Answers(2, ""));
    ASSERT_TRUE(r.last.trip);
    EXPECT_EQ(r.last.trip->cause, safety::Cause::walker_edge);
    const auto run = std::ranges::find_if(
        r.events, [](const BenchEvent& e) { return e.kind == "state" && e.text == "run"; });
    ASSERT_NE(run, r.events.end());
    EXPECT_NEAR(static_cast<double>(r.last.trip->tick) / 48000, run->t_s + 20 / 20.0, 0.02);
}

TEST_F(EdgeTest, HiddenWalkerTripsOnTheWayBack) {
    const auto r = after_the_edge(
        near_the_edge("", "[[fault]]\nwhat = \"walker_hidden\"\nat_s = 8.3\n"),
        {{in(RunState::idle), give(SetDrive{turned_back()})}, start(), until(in(RunState::tripped))},
        {0.113, 0.001});
    EXPECT_EQ(answers, Answers(2, ""));
    ASSERT_TRUE(r.last.trip);
    EXPECT_EQ(r.last.trip->cause, safety::Cause::tracking_lost);
}

TEST_F(EdgeTest, IdentificationStartsInsideTheEdgeOnly) {
    const auto r =
        play(near_the_edge("", "", "45"), {{in(RunState::idle), give(Identify{})}}, 5, {0.113, 0.001});
    ASSERT_EQ(answers.size(), 1U);
    EXPECT_NE(answers[0].find("from the edge of the picture"), std::string::npos) << answers[0];
    EXPECT_TRUE(test::entered(r, RunState::identify).empty()) << test::log_of(r);
}

TEST_F(EdgeTest, IdentificationThatMovesTheWalkerOutTrips) {
    options.drive.gamma = 40;
    const auto r = play(near_the_edge("", "", "-42"),
                        {{in(RunState::idle), give(Identify{})}, until(in(RunState::tripped))}, 20);
    ASSERT_TRUE(r.last.trip) << test::log_of(r);
    EXPECT_EQ(r.last.trip->cause, safety::Cause::walker_edge);
    EXPECT_TRUE(test::entered(r, RunState::ramp_down).empty()) << test::log_of(r);
}

}  // namespace
}  // namespace shaker::service

// No drive without a fresh view of the walker.
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/run/bench_on_call.hpp"

namespace shaker::service {
namespace {

using run::RunState;
using test::entered;
using test::fault;
using test::from_s;
using test::in;
using test::slow;
using test::until;

class WalkerViewTest : public test::OnCallBench {
protected:
    WalkerViewTest() { options.drive.phi = 1.75; }  // a slow walk
};

std::string stall(double at_s, double for_s, const std::string& camera = "") {
    return fault(
        "camera_stall", at_s,
        "for_s = " + std::to_string(for_s) + "\n" + (camera.empty() ? "" : "camera = \"" + camera + "\"\n"));
}

std::size_t noted(const test::OnCallResult& r, const std::string& words) {
    return static_cast<std::size_t>(std::ranges::count_if(r.events, [&](const BenchEvent& e) {
        return e.kind == "note" && e.text.find(words) != std::string::npos;
    }));
}

double tripped_s(const test::OnCallResult& r) {
    return static_cast<double>(r.last.trip->tick) / r.last.facts->dac.rate_hz;
}

// SAFE-10
TEST_F(WalkerViewTest, SilenceOfAllCamerasStopsSoftly) {
    const auto r = play(slow + stall(9, 100), {start(), until(in(RunState::tripped))}, 20);
    ASSERT_TRUE(r.last.trip) << test::log_of(r);
    EXPECT_EQ(r.last.trip->cause, safety::Cause::camera_missing);
    EXPECT_EQ(r.last.trip->stop, safety::StopKind::soft);
    EXPECT_NEAR(tripped_s(r), 9.25, 0.02);
    EXPECT_FALSE(r.last.walker) << "a place that is not seen any more is not shown";
}

TEST_F(WalkerViewTest, OtherCameraTakesOver) {
    for (const char* camera : {"top", "side"}) {
        const auto r = play(slow + stall(9, 100, camera),
                            {start(), {from_s(14), give(End{})}, until(in(RunState::idle))});
        EXPECT_EQ(answers, test::Answers(2, "")) << camera;
        EXPECT_EQ(r.last.trips, 0U) << camera << test::log_of(r);
        EXPECT_GT(r.last.measured_from_s, 10) << camera << ": still measured";
        EXPECT_EQ(noted(r, "camera \"side\" is followed"), std::string{camera} == "top" ? 1U : 0U);
    }
}

// The picture of the side camera shows the way; its silence comes after that of the top camera.
TEST_F(WalkerViewTest, CameraThatTookOverIsWatched) {
    const auto r = play(slow + stall(8, 100, "top") + stall(10, 100, "side"),
                        {start(), until(in(RunState::tripped))}, 20);
    ASSERT_TRUE(r.last.trip) << test::log_of(r);
    EXPECT_EQ(r.last.trip->cause, safety::Cause::camera_missing);
    EXPECT_NEAR(tripped_s(r), 10.25, 0.02);
}

// 0.25 s are less than ten frames.
TEST_F(WalkerViewTest, SlowCameraMayMissTenFrames) {
    const std::string ten_hz =
        "[top]\npositions = 1\nframe_rate_hz = 10\n[side]\npositions = 1\nframe_rate_hz = 10\n";
    const auto r = play(ten_hz + stall(9, 0.6) + stall(11, 100), {start(), until(in(RunState::tripped))}, 20);
    ASSERT_TRUE(r.last.trip) << test::log_of(r);
    EXPECT_NEAR(tripped_s(r), 12, 0.11);
}

// As of a camera behind a slow network.
TEST_F(WalkerViewTest, SteadyDelayIsNotSilence) {
    const std::string late =
        "[top]\npositions = 1\nframe_rate_hz = 200\nlatency_s = 0.4\n"
        "[side]\npositions = 1\nframe_rate_hz = 200\nlatency_s = 0.4\n";
    const auto r = play(late, {start(), {from_s(12), give(End{})}, until(in(RunState::idle))}, 20);
    EXPECT_EQ(answers, test::Answers(2, ""));
    EXPECT_EQ(r.last.trips, 0U) << test::log_of(r);
}

TEST_F(WalkerViewTest, NoDriveStartsWithoutPictures) {
    for (const std::string& blind : {stall(0, 100), stall(1, 100), fault("walker_hidden", 1)}) {
        const auto r =
            play(slow + blind,
                 {{from_s(2), give(Begin{10})}, {from_s(2.5), give(Identify{})}, until(from_s(3))}, 5);
        ASSERT_EQ(answers.size(), 2U);
        for (const std::string& answer : answers)
            EXPECT_NE(answer.find("the walker is in no picture"), std::string::npos) << answer;
        EXPECT_TRUE(entered(r, RunState::loop_check).empty()) << test::log_of(r);
        EXPECT_TRUE(entered(r, RunState::identify).empty()) << test::log_of(r);
    }
}

// Another frequency begins another fold of the drift, but not another view.
TEST_F(WalkerViewTest, OtherFrequencyDoesNotRefreshTheView) {
    std::vector<test::Move> moves{start()};
    for (int i = 0; i < 8; ++i)
        moves.push_back({[i](const BenchState& s) { return s.now_s > 9 + 0.1 * i; },
                         give(SetDrive{{.frequency = i % 2 == 0 ? 21.0 : 20.0, .gamma = 4, .phi = 1.75}})});
    moves.push_back(until(in(RunState::tripped)));
    const auto r = play(slow + stall(9, 100), moves, 20);
    ASSERT_TRUE(r.last.trip) << test::log_of(r);
    EXPECT_EQ(r.last.trip->cause, safety::Cause::camera_missing);
    EXPECT_NEAR(tripped_s(r), 9.25, 0.02);
}

}  // namespace
}  // namespace shaker::service

// The check of a known response at a low level before each drive from rest.
#include <gtest/gtest.h>

#include <algorithm>

#include "daemon/commands/replay.hpp"
#include "tests/support/run/bench_on_call.hpp"

namespace shaker::service {
namespace {

using run::RunState;
using test::Answers;
using test::in;
using test::measured;
using test::until;

constexpr double fault_s = 7;  // the response is identified until 6.6 s

std::string scene(const std::string& fault) {
    std::string text = test::slow;
    text += "[accelerometer]\naxis_told = 1\n";
    if (!fault.empty()) text += "[[fault]]\nat_s = 7\n" + fault;
    return text;
}

class LoopCheckedTest : public test::OnCallBench {
protected:
    // Identifies, waits for the fault, starts a drive and waits for this state.
    test::OnCallResult started_after(const std::string& fault, RunState last) {
        return play(scene(fault),
                    {{in(RunState::idle), give(Identify{})},
                     {test::from_s(fault_s + 0.2), give(Begin{10})},
                     until(in(last))},
                    30);
    }
};

// Master times of this text among the events.
std::vector<double> times_of(const test::OnCallResult& r, const std::string& text) {
    std::vector<double> times;
    for (const BenchEvent& e : r.events)
        if (e.text.find(text) != std::string::npos) times.push_back(e.t_s);
    return times;
}

void expect_no_drive(const test::OnCallResult& r, safety::Cause cause, const std::string& words) {
    ASSERT_TRUE(r.last.trip);
    EXPECT_EQ(r.last.trip->cause, cause) << test::log_of(r);
    EXPECT_EQ(times_of(r, words).size(), 1U) << words;
    EXPECT_TRUE(times_of(r, "ramp").empty() || times_of(r, "ramp").back() < fault_s) << "no drive";
}

TEST_F(LoopCheckedTest, DriveFromRestIsCheckedWithinTime) {
    const auto r = started_after("", RunState::run);
    EXPECT_EQ(answers, Answers(2, ""));
    ASSERT_EQ(times_of(r, "loop_check").size(), 1U);
    const std::vector<double> ramps = times_of(r, "ramp");
    ASSERT_FALSE(ramps.empty());
    const double took_s = ramps.back() - times_of(r, "loop_check")[0];
    std::printf("loop check: %.3f s\n", took_s);
    EXPECT_LT(took_s, 1.5);
    EXPECT_FALSE(r.last.trip) << test::log_of(r);
}

TEST_F(LoopCheckedTest, WrongGainDoesNotDrive) {
    for (const char* gain : {"0.4", "2"}) {
        const auto r =
            started_after(std::string{"what = \"amplifier_gain\"\nvalue = "}.append(gain), RunState::tripped);
        expect_no_drive(r, safety::Cause::gain_limit, "loop check: gain");
    }
}

TEST_F(LoopCheckedTest, WrongPolarityDoesNotDrive) {
    const auto r = started_after("what = \"amplifier_gain\"\nvalue = -1", RunState::tripped);
    expect_no_drive(r, safety::Cause::polarity, "loop check: polarity");
}

TEST_F(LoopCheckedTest, AmplifierThatIsOffDoesNotDrive) {
    const auto r = started_after("what = \"amplifier_gain\"\nvalue = 1e-4", RunState::tripped);
    expect_no_drive(r, safety::Cause::sensor_open, "loop check: noise");
}

TEST_F(LoopCheckedTest, RecordingWithACheckReplays) {
    const auto r =
        play(scene(""), {{in(RunState::idle), give(Identify{})},
                         until(in(RunState::identify)),
                         {in(RunState::idle), give(Record{true, "checked", recorded::KeptPictures::off})},
                         start(),
                         {measured(1), give(End{})},
                         until(in(RunState::idle))});
    EXPECT_EQ(answers, Answers(4, ""));
    EXPECT_EQ(times_of(r, "loop_check").size(), 1U);
    EXPECT_TRUE(commands::replay({.file = folder / "checked.nxs"}));
}

TEST_F(LoopCheckedTest, UnderrunIsFollowedByACheck) {
    const auto r =
        play(scene("what = \"underrun\"\nvalue = 480"),
             {start(),
              {[](const BenchState& s) { return s.now_s > 7.2 && s.state == RunState::run; }, give(End{})},
              until(in(RunState::idle))},
             30);
    EXPECT_EQ(answers, Answers(2, ""));
    EXPECT_EQ(times_of(r, "loop_check").size(), 1U) << "none after the identification";
    EXPECT_FALSE(r.last.trip) << test::log_of(r);
}

TEST_F(LoopCheckedTest, DriveDoesNotReturnWithOtherPolarity) {
    const auto r = play(scene("what = \"underrun\"\nvalue = 480\n[[fault]]\nat_s = 7.001\nwhat = "
                              "\"amplifier_gain\"\nvalue = -1"),
                        {start(), until(in(RunState::tripped))}, 30);
    expect_no_drive(r, safety::Cause::polarity, "loop check: polarity");
}

}  // namespace
}  // namespace shaker::service

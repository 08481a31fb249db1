// The check of a known response at a low level before each drive from rest.
#include <gtest/gtest.h>

#include <algorithm>

#include "daemon/commands/replay_command.hpp"
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

constexpr double fault_s = 7;  // the response is identified until 6.6 s

std::string scene(const std::string& fault) {
    std::string text = test::slow;
    text += "[accelerometer]\naxis_told = 1\n";
    if (!fault.empty()) text += "[[fault]]\nat_s = 7\n" + fault;
    return text;
}

auto at(double s) {
    return [s](const BenchState& b) { return b.now_s > s; };
}

// Identifies, waits for the fault, starts a drive and waits for this state.
test::OnCallResult started_after(const std::string& fault, RunState last, Answers& answers) {
    return play_on_call(scene(fault), quick(), test::fresh_folder(),
                        {{in(RunState::idle), orders(Identify{}, answers)},
                         {at(fault_s + 0.2), orders(Begin{10}, answers)},
                         {in(last), [](BenchPort&) {}}},
                        30);
}

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

TEST(LoopCheckedTest, DriveFromRestIsCheckedWithinTime) {
    Answers answers;
    const auto r = started_after("", RunState::run, answers);
    EXPECT_EQ(answers, Answers(2, ""));
    ASSERT_EQ(times_of(r, "loop_check").size(), 1U);
    const std::vector<double> ramps = times_of(r, "ramp");
    ASSERT_FALSE(ramps.empty());
    const double took_s = ramps.back() - times_of(r, "loop_check")[0];
    std::printf("loop check: %.3f s\n", took_s);
    EXPECT_LT(took_s, 1.5);
    EXPECT_FALSE(r.last.trip) << test::log_of(r);
}

TEST(LoopCheckedTest, WrongGainDoesNotDrive) {
    for (const char* gain : {"0.4", "2"}) {
        Answers answers;
        const auto r = started_after(std::string{"what = \"amplifier_gain\"\nvalue = "}.append(gain),
                                     RunState::tripped, answers);
        expect_no_drive(r, safety::Cause::gain_limit, "loop check: gain");
    }
}

TEST(LoopCheckedTest, WrongPolarityDoesNotDrive) {
    Answers answers;
    const auto r = started_after("what = \"amplifier_gain\"\nvalue = -1", RunState::tripped, answers);
    expect_no_drive(r, safety::Cause::polarity, "loop check: polarity");
}

TEST(LoopCheckedTest, AmplifierThatIsOffDoesNotDrive) {
    Answers answers;
    const auto r = started_after("what = \"amplifier_gain\"\nvalue = 1e-4", RunState::tripped, answers);
    expect_no_drive(r, safety::Cause::sensor_open, "loop check: noise");
}

TEST(LoopCheckedTest, RecordingWithACheckReplays) {
    const auto folder = test::fresh_folder();
    Answers answers;
    const auto r = play_on_call(
        scene(""), quick(), folder,
        {{in(RunState::idle), orders(Identify{}, answers)},
         {in(RunState::identify), [](BenchPort&) {}},
         {in(RunState::idle), orders(Record{true, "checked", recorded::KeptPictures::off}, answers)},
         {in(RunState::idle), orders(Begin{10}, answers)},
         {[](const BenchState& s) { return !s.points.empty(); }, orders(End{}, answers)},
         {in(RunState::idle), [](BenchPort&) {}}});
    EXPECT_EQ(answers, Answers(4, ""));
    EXPECT_EQ(times_of(r, "loop_check").size(), 1U);
    EXPECT_TRUE(commands::replay({.file = folder / "checked.nxs"}));
}

TEST(LoopCheckedTest, UnderrunIsFollowedByACheck) {
    Answers answers;
    const auto r =
        play_on_call(scene("what = \"underrun\"\nvalue = 480"), quick(), test::fresh_folder(),
                     {{in(RunState::idle), orders(Begin{10}, answers)},
                      {[](const BenchState& s) { return s.now_s > 7.2 && s.state == RunState::run; },
                       orders(End{}, answers)},
                      {in(RunState::idle), [](BenchPort&) {}}},
                     30);
    EXPECT_EQ(answers, Answers(2, ""));
    EXPECT_EQ(times_of(r, "loop_check").size(), 1U) << "none after the identification";
    EXPECT_FALSE(r.last.trip) << test::log_of(r);
}

TEST(LoopCheckedTest, DriveDoesNotReturnWithOtherPolarity) {
    Answers answers;
    const auto r = play_on_call(
        scene("what = \"underrun\"\nvalue = 480\n[[fault]]\nat_s = 7.001\nwhat = "
              "\"amplifier_gain\"\nvalue = -1"),
        quick(), test::fresh_folder(),
        {{in(RunState::idle), orders(Begin{10}, answers)}, {in(RunState::tripped), [](BenchPort&) {}}}, 30);
    expect_no_drive(r, safety::Cause::polarity, "loop check: polarity");
}

}  // namespace
}  // namespace shaker::service

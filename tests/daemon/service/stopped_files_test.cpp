// An operator's abort on call, and what it leaves on the disk.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "tests/support/run/bench_on_call.hpp"

namespace shaker::service {
namespace {

using test::Answers;
using test::in;
using test::may_clear;
using test::measured;
using test::slow;
using test::until;

using StoppedFilesTest = test::OnCallBench;

TEST_F(StoppedFilesTest, IsLatchedUntilCleared) {
    const auto r = play(slow, {start(),
                               {in(run::RunState::run), [](BenchPort& d) { d.abort("a test"); }},
                               {may_clear, give(Begin{10})},
                               {in(run::RunState::tripped), give(ClearTrip{})},
                               start(),
                               {measured(1), give(End{})},
                               until(in(run::RunState::idle))});
    ASSERT_EQ(answers.size(), 5U) << testing::PrintToString(answers);
    EXPECT_NE(answers[1].find("the bench is tripped"), std::string::npos) << answers[1];
    for (const std::size_t i : {0U, 2U, 3U, 4U}) EXPECT_EQ(answers[i], "");
    const auto stop = std::ranges::find(r.events, std::string{"trip"}, &BenchEvent::kind);
    ASSERT_NE(stop, r.events.end());
    EXPECT_NE(stop->text.find("operator_stop"), std::string::npos) << stop->text;
}

TEST_F(StoppedFilesTest, AtRestWritesNoFile) {
    const auto abort = [](BenchPort& d) { d.abort("a test"); };
    const auto r = play(slow, {{in(run::RunState::idle), abort},
                               {may_clear, give(ClearTrip{})},
                               {in(run::RunState::idle), abort},
                               {may_clear, give(ClearTrip{})},
                               until(in(run::RunState::idle))});
    EXPECT_EQ(answers, Answers(2, ""));
    EXPECT_EQ(r.last.trips, 2U);
    for (const auto& file : std::filesystem::directory_iterator{folder})
        EXPECT_FALSE(file.path().filename().string().starts_with("trip-")) << file.path();
}

TEST_F(StoppedFilesTest, OfADriveWritesItsEnd) {
    play(slow,
         {start(), {in(run::RunState::run), [](BenchPort& d) { d.abort("a test"); }}, until(may_clear)});
    const auto all = std::filesystem::directory_iterator{folder};
    EXPECT_TRUE(std::any_of(begin(all), end(all), [](const auto& file) {
        return file.path().filename().string().starts_with("trip-") && file.path().extension() == ".nxs";
    }));
}

// SAFE-15
TEST_F(StoppedFilesTest, EachTripAtRestWritesItsEnd) {
    std::string scene = slow;
    std::vector<test::Move> moves;
    constexpr int trips = 4;
    for (int i = 0; i < trips; ++i) {
        scene += test::fault("contact_open", 2 + 2 * i, "for_s = 0.05\n");
        moves.push_back(
            {[i](const BenchState& s) { return s.may_clear && s.now_s > 2 + 2 * i; }, give(ClearTrip{})});
    }
    moves.push_back(until(test::from_s(2 + 2 * trips)));
    const auto r = play(scene, moves);
    EXPECT_EQ(answers, Answers(trips, ""));
    EXPECT_EQ(r.last.trips, std::size_t{trips});
    std::size_t files = 0;
    for (const auto& file : std::filesystem::directory_iterator{folder})
        files += file.path().filename().string().starts_with("trip-") ? 1 : 0;
    EXPECT_EQ(files, std::size_t{trips}) << log_of(r);
}

}  // namespace
}  // namespace shaker::service

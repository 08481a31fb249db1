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
    EXPECT_NE(answers[1].find("state tripped"), std::string::npos) << answers[1];
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

}  // namespace
}  // namespace shaker::service

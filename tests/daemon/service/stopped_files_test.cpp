// An operator's abort on call, and what it leaves on the disk.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "tests/support/program.hpp"
#include "tests/support/run/bench_on_call.hpp"

namespace shaker::service {
namespace {

using test::Answers;
using test::in;
using test::orders;
using test::play_on_call;
using test::quick;
using test::slow;

auto measured(std::size_t n) {
    return [n](const BenchState& s) { return s.points.size() >= n; };
}

TEST(StoppedFilesTest, IsLatchedUntilCleared) {
    const auto folder = test::fresh_folder();
    Answers answers;
    const auto r =
        play_on_call(slow, quick(), folder,
                     {{in(run::RunState::idle), orders(Begin{10}, answers)},
                      {in(run::RunState::run), [](BenchPort& d) { d.abort("a test"); }},
                      {[](const BenchState& s) { return s.may_clear; }, orders(Begin{10}, answers)},
                      {in(run::RunState::tripped), orders(ClearTrip{}, answers)},
                      {in(run::RunState::idle), orders(Begin{10}, answers)},
                      {measured(1), orders(End{}, answers)},
                      {in(run::RunState::idle), [](BenchPort&) {}}});
    ASSERT_EQ(answers.size(), 5U) << testing::PrintToString(answers);
    EXPECT_NE(answers[1].find("state tripped"), std::string::npos) << answers[1];
    for (const std::size_t i : {0U, 2U, 3U, 4U}) EXPECT_EQ(answers[i], "");
    const auto stop = std::ranges::find(r.events, std::string{"trip"}, &BenchEvent::kind);
    ASSERT_NE(stop, r.events.end());
    EXPECT_NE(stop->text.find("operator_stop"), std::string::npos) << stop->text;
}

TEST(StoppedFilesTest, AtRestWritesNoFile) {
    const auto folder = test::fresh_folder();
    Answers answers;
    const auto abort = [](BenchPort& d) { d.abort("a test"); };
    const auto clearable = [](const BenchState& s) { return s.may_clear; };
    const auto r = play_on_call(slow, quick(), folder,
                                {{in(run::RunState::idle), abort},
                                 {clearable, orders(ClearTrip{}, answers)},
                                 {in(run::RunState::idle), abort},
                                 {clearable, orders(ClearTrip{}, answers)},
                                 {in(run::RunState::idle), [](BenchPort&) {}}});
    EXPECT_EQ(answers, Answers(2, ""));
    EXPECT_EQ(r.last.trips, 2U);
    for (const auto& file : std::filesystem::directory_iterator{folder})
        EXPECT_FALSE(file.path().filename().string().starts_with("trip-")) << file.path();
}

TEST(StoppedFilesTest, OfADriveWritesItsEnd) {
    const auto folder = test::fresh_folder();
    Answers answers;
    play_on_call(slow, quick(), folder,
                 {{in(run::RunState::idle), orders(Begin{10}, answers)},
                  {in(run::RunState::run), [](BenchPort& d) { d.abort("a test"); }},
                  {[](const BenchState& s) { return s.may_clear; }, [](BenchPort&) {}}});
    const auto all = std::filesystem::directory_iterator{folder};
    EXPECT_TRUE(std::any_of(begin(all), end(all), [](const auto& file) {
        return file.path().filename().string().starts_with("trip-") && file.path().extension() == ".nxs";
    }));
}

}  // namespace
}  // namespace shaker::service

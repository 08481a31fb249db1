// The journal decides which points are measured. No measurement is counted twice.
#include "daemon/campaign/progress.hpp"

#include <gtest/gtest.h>
#include <spdlog/fmt/fmt.h>

#include <random>
#include <set>

#include "tests/support/recording/recording_folder.hpp"

namespace shaker::campaign {
namespace {

using test::expect_in;
using test::refusal;
using What = decltype(JournalEntry::what);

PassEnded pass(int point, int number, int measurement) {
    return {.point = point, .pass = number, .recording = "r1", .measurement = measurement, .reason = {}};
}

// Follows `what` behind the beginning of a campaign.
Progress after(const std::vector<What>& what) {
    std::vector<JournalEntry> entries{{"t", CampaignChange{CampaignChange::What::begun, "", "sha"}}};
    for (const What& w : what) entries.push_back({"t", w});
    return progress_of(entries);
}

// The remarks of a journal that can be read.
std::string remarked(const std::vector<What>& what) {
    return fmt::format("{}", fmt::join(after(what).remarks, "; "));
}

const PointEnded measured{1, Outcome::measured, ""}, failed{1, Outcome::failed, "a trip"};

TEST(ProgressTest, DerivesDoneAndInProgressPoints) {
    const Progress p = after({PointBegun{1}, pass(1, 1, 1), pass(1, 2, 2), measured, PointBegun{2},
                              pass(2, 1, 3), PointEnded{3, Outcome::left_out, "does not fit"}});
    EXPECT_TRUE(p.done(1));
    EXPECT_FALSE(p.done(2)) << "in progress";
    EXPECT_TRUE(p.done(3)) << "left out without having been begun";
    EXPECT_FALSE(p.done(4)) << "not begun";
    EXPECT_EQ(p.points.at(1).passes.size(), 2U);
    EXPECT_EQ(p.points.at(2).passes.size(), 1U);
    EXPECT_EQ(p.plan, "sha");
}

TEST(ProgressTest, SecondTrySupersedesPasses) {
    const std::vector<What> first{PointBegun{1}, pass(1, 1, 1), failed};
    EXPECT_EQ(after(first).points.at(1).ended->reason, "a trip");
    std::vector<What> again = first;
    again.insert(again.end(), {PointBegun{1}, pass(1, 1, 2), measured});
    const Progress p = after(again);
    EXPECT_TRUE(p.done(1));
    EXPECT_EQ(p.points.at(1).begun, 2);
    EXPECT_EQ(p.points.at(1).superseded, 1);
    ASSERT_EQ(p.points.at(1).passes.size(), 1U);
    EXPECT_EQ(p.points.at(1).passes[0].measurement, 2);
}

TEST(ProgressTest, ContinuedPointKeepsItsPasses) {
    const Progress p =
        after({PointBegun{1}, pass(1, 1, 1), CampaignChange{CampaignChange::What::continued, "", ""},
               PointBegun{1, true}, pass(1, 2, 2), measured});
    EXPECT_EQ(p.points.at(1).passes.size(), 2U);
    EXPECT_EQ(p.points.at(1).begun, 1);
}

TEST(ProgressTest, LostPassMakesPointUnmeasured) {
    const Progress p = after({PointBegun{1}, pass(1, 1, 1), pass(1, 2, 2), measured, PassLost{1, 2, "torn"}});
    EXPECT_FALSE(p.done(1));
    EXPECT_EQ(p.points.at(1).passes.size(), 1U);
    expect_in(remarked({PointBegun{1}, pass(1, 1, 1), PassLost{1, 2, ""}}), {"entry 4", "no pass 2"});
    expect_in(remarked({PassLost{1, 1, ""}}), {"no pass 1"});
}

TEST(ProgressTest, NothingIsCountedTwice) {
    const std::vector<What> moved{PointBegun{1}, pass(1, 1, 4), measured, PointBegun{2}, pass(2, 1, 4)};
    expect_in(remarked(moved), {"entry 6", "measurement 4 of r1.nxs", "point 1"});
    EXPECT_FALSE(after(moved).done(1)) << "its measurement counts for point 2";
    EXPECT_EQ(after(moved).points.at(2).passes.size(), 1U);
    const std::vector<What> told_twice{PointBegun{1}, pass(1, 1, 1), pass(1, 1, 2), measured};
    expect_in(remarked(told_twice), {"entry 4", "pass 1 of point 1"});
    ASSERT_EQ(after(told_twice).points.at(1).passes.size(), 1U);
    EXPECT_EQ(after(told_twice).points.at(1).passes[0].measurement, 2) << "the last one";
    expect_in(remarked({PointBegun{1}, pass(1, 1, 1), measured, PointBegun{1}}),
              {"entry 5", "measured already"});
    // Failed passes have no measurement, so several may.
    EXPECT_EQ(after({PointBegun{1}, pass(1, 1, 0), pass(1, 2, 0)}).points.at(1).passes.size(), 2U);
    EXPECT_EQ(remarked({PointBegun{1}, pass(1, 1, 0), pass(1, 2, 0)}), "");
}

// What a campaign wrote whose drive tripped between a measurement and its result, or whose recording was
// full.
TEST(ProgressTest, FailureOfAMeasuredPassLosesNothing) {
    for (const auto& two :
         {std::pair{pass(1, 1, 0), pass(1, 1, 4)}, std::pair{pass(1, 1, 4), pass(1, 1, 0)}}) {
        const Progress p = after({PointBegun{1}, two.first, two.second, measured});
        ASSERT_EQ(p.points.at(1).passes.size(), 1U);
        EXPECT_EQ(p.points.at(1).passes[0].measurement, 4);
        EXPECT_TRUE(p.done(1));
        EXPECT_EQ(p.remarks.size(), 1U);
    }
}

TEST(ProgressTest, LateEntriesAreRemarks) {
    expect_in(remarked({pass(1, 1, 1)}), {"entry 2", "point 1 is not in progress"});
    const Progress late = after({PointBegun{1}, failed, pass(1, 1, 1)});
    expect_in(late.remarks.front(), {"entry 4", "not in progress"});
    EXPECT_TRUE(late.done(1));
    EXPECT_TRUE(late.points.at(1).passes.empty());
    expect_in(remarked({PointBegun{1}, measured}), {"entry 3", "without a measurement"});
    EXPECT_FALSE(after({PointBegun{1}, measured}).done(1));
    const PointEnded out{1, Outcome::left_out, "by the operator"};
    const Progress twice = after({PointBegun{1}, out, out});
    EXPECT_TRUE(twice.done(1)) << "skip, repeat and skip";
    EXPECT_EQ(twice.remarks.size(), 1U);
}

TEST(ProgressTest, JournalOfAnotherCampaignIsRefused) {
    expect_in(refusal([] {
                  after({CampaignChange{CampaignChange::What::begun, "", "sha"}});
              }),
              {"entry 2", "begun already"});
    expect_in(refusal([] {
                  progress_of(
                      std::vector<JournalEntry>{{"t", CampaignChange{CampaignChange::What::paused, "", ""}}});
              }),
              {"entry 1", "has not begun"});
}

// Any order of entries is read, and done() never claims a measurement that is not there.
TEST(ProgressTest, RandomEntriesAreRead) {
    std::mt19937_64 random{1};
    const auto any = [&](int n) { return static_cast<int>(random() % static_cast<unsigned>(n)); };
    for (int k = 0; k < 2000; ++k) {
        std::vector<What> what;
        for (int i = 0; i < 30; ++i) {
            const int point = 1 + any(3), number = 1 + any(3);
            const std::array<What, 5> kinds{
                PointBegun{point, any(2) == 0}, pass(point, number, any(6)), PassLost{point, number, ""},
                PointEnded{point, static_cast<Outcome>(any(3)), ""}, Returned{.point = point}};
            what.push_back(kinds.at(static_cast<std::size_t>(any(5))));
        }
        const Progress p = after(what);
        std::set<std::pair<std::string, int>> counted;
        for (const auto& [id, one] : p.points) {
            bool has = false;
            for (const PassEnded& e : one.passes)
                if (e.measurement > 0) {
                    EXPECT_TRUE(counted.insert({e.recording, e.measurement}).second) << "counted twice";
                    has = true;
                }
            if (one.ended && one.ended->outcome == Outcome::measured) {
                EXPECT_TRUE(has);
            }
        }
    }
}

}  // namespace
}  // namespace shaker::campaign

// The journal decides which points are measured. No measurement is counted twice.
#include "daemon/campaign/progress.hpp"

#include <gtest/gtest.h>

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

std::string refused(const std::vector<What>& what) {
    return refusal([&] { after(what); });
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
    expect_in(refused({PointBegun{1}, pass(1, 1, 1), PassLost{1, 2, ""}}), {"entry 4", "no pass 2"});
    expect_in(refused({PassLost{1, 1, ""}}), {"no pass 1"});
}

TEST(ProgressTest, NothingIsCountedTwice) {
    expect_in(refused({PointBegun{1}, pass(1, 1, 4), measured, PointBegun{2}, pass(2, 1, 4)}),
              {"entry 6", "measurement 4 of r1.nxs", "by entry 3"});
    expect_in(refused({PointBegun{1}, pass(1, 1, 1), pass(1, 1, 2)}), {"entry 4", "pass 1 of point 1"});
    expect_in(refused({PointBegun{1}, pass(1, 1, 1), measured, PointBegun{1}}),
              {"entry 5", "measured already"});
    expect_in(refused({PointBegun{1}, pass(1, 1, 1), failed, PointBegun{1}, pass(1, 1, 1)}),
              {"counted already"});
    // Failed passes have no measurement, so several may.
    EXPECT_EQ(after({PointBegun{1}, pass(1, 1, 0), pass(1, 2, 0)}).points.at(1).passes.size(), 2U);
}

TEST(ProgressTest, ImpossibleEntriesAreRefused) {
    expect_in(refused({pass(1, 1, 1)}), {"entry 2", "point 1 is not in progress"});
    expect_in(refused({PointBegun{1}, failed, pass(1, 1, 1)}), {"entry 4", "not in progress"});
    expect_in(refused({PointBegun{1}, measured}), {"entry 3", "without a measurement"});
    expect_in(refused({CampaignChange{CampaignChange::What::begun, "", "sha"}}),
              {"entry 2", "begun already"});
    expect_in(refusal([] {
                  progress_of(
                      std::vector<JournalEntry>{{"t", CampaignChange{CampaignChange::What::paused, "", ""}}});
              }),
              {"entry 1", "has not begun"});
}

}  // namespace
}  // namespace shaker::campaign

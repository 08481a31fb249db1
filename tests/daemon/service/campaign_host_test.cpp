// Campaigns that a client orders from a bench on call.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numbers>
#include <set>
#include <string>

#include "daemon/campaign/campaign_folder.hpp"
#include "daemon/campaign/lead/plans.hpp"
#include "daemon/campaign/points_table.hpp"
#include "drivers/errors.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/recording/recording_folder.hpp"
#include "tests/support/run/bench_on_call.hpp"

namespace shaker::service {
namespace {

using run::RunState;
using test::Answers;
using test::in;
using test::until;

bool ended(const BenchState& s) { return s.campaign && !s.campaign->active && s.state == RunState::idle; }
bool measuring(const BenchState& s) { return s.campaign && s.campaign->active && s.measuring; }
bool waits(const BenchState& s) { return s.campaign && s.campaign->paused && s.state == RunState::idle; }

class CampaignHostTest : public test::OnCallBench {
protected:
    [[nodiscard]] test::Move scan() {
        return {in(RunState::idle), give(MeasurePlan{"scan", campaign::text_of({.from = 0,
                                                                                .to = std::numbers::pi,
                                                                                .steps = 2,
                                                                                .rest = {.gamma = paper_g},
                                                                                .periods = 10})})};
    }
    [[nodiscard]] std::filesystem::path of(const test::OnCallResult& r) const {
        return folder / r.last.campaign->folder;
    }
};

TEST_F(CampaignHostTest, MeasuresAScanAndWritesItsTable) {
    const auto r = play(test::slow, {scan(), until(ended)}, 120);
    EXPECT_EQ(answers, Answers(1, "")) << test::log_of(r);
    const campaign::PointsTable table = campaign::read_points(of(r) / campaign::table_name);
    ASSERT_EQ(table.points.size(), 3U);
    for (const campaign::PointRow& row : table.points) {
        EXPECT_EQ(row.outcome, "measured") << row.reason;
        EXPECT_NEAR(row.v_D.value, row.true_v_D, 4 * row.v_D.sigma) << row.point;
    }
    EXPECT_EQ(r.last.campaign->ended, 3U);
    EXPECT_GE(r.last.points.size(), 3U) << "clients see each measurement";
    EXPECT_EQ(r.last.wanted.gamma, paper_g) << "the set-point is that of the campaign";
}

// A campaign takes a third of a second here, so at least two of them begin in the same one.
TEST_F(CampaignHostTest, CampaignsOfOneSecondHaveTheirOwnFolders) {
    std::set<std::string> folders;
    const auto has_ended = [&](const BenchState& s) {
        return ended(s) && folders.insert(s.campaign->folder).second;
    };
    const auto r =
        play(test::slow, {scan(), until(has_ended), scan(), until(has_ended), scan(), until(has_ended)}, 240);
    EXPECT_EQ(answers, Answers(3, "")) << test::log_of(r);
    for (const std::string& name : folders)
        EXPECT_EQ(campaign::read_points(folder / name / campaign::table_name).points.size(), 3U) << name;
}

// The same plan as in MeasuresAScanAndWritesItsTable, and one whose walk is longer than the view.
TEST_F(CampaignHostTest, APlanIsCheckedBeforeAnythingMoves) {
    const auto plan = [](int steps, int periods) {
        return campaign::text_of(
            {.to = std::numbers::pi, .steps = steps, .rest = {.gamma = paper_g}, .periods = periods});
    };
    const auto seen = [](const BenchState& s) {
        return s.state == RunState::idle && s.walker && s.walker->x_m != 0;
    };
    const auto r = play(test::slow,
                        {{seen, give(CheckPlan{"scan", plan(2, 10)})},
                         {[](const BenchState& s) { return s.plan_check && s.plan_check->points == 3; },
                          give(CheckPlan{"long", plan(1, 5000)})},
                         {in(RunState::idle), give(CheckPlan{"bad", "[[series]]\ngamma = \"40g\"\n"})},
                         {in(RunState::idle), give(CheckPlan{"unknown"})}},
                        20);
    ASSERT_EQ(answers.size(), 4U);
    EXPECT_EQ(answers[0], "");
    EXPECT_EQ(answers[1], "");
    test::expect_in(answers[2], {"bad:2"});
    test::expect_in(answers[3], {"no such plan"});
    ASSERT_TRUE(r.last.plan_check);
    const PlanCheckState& check = *r.last.plan_check;
    EXPECT_EQ(check.name, "long");
    EXPECT_EQ(check.points, 2U);
    EXPECT_FALSE(r.last.campaign);
    EXPECT_TRUE(std::ranges::any_of(r.events, [](const BenchEvent& e) {
        return e.text.starts_with("plan scan: 3 points, 3 fit; bench time ");
    })) << test::log_of(r);
}

TEST_F(CampaignHostTest, ItHasTheBenchUntilItEnds) {
    Drive other;
    other.phi = 1;
    const auto r = play(test::slow,
                        {scan(),
                         {measuring, give(SetDrive{other})},
                         {measuring, give(Begin{10})},
                         {measuring, give(MeasurePlan{"again", "x"})},
                         {measuring, give(TellCampaign{campaign::Word::stop})},
                         until(ended)},
                        120);
    ASSERT_EQ(answers.size(), 5U);
    for (const std::size_t i : {1U, 2U}) test::expect_in(answers[i], {"campaign is measured", "stop"});
    EXPECT_NE(answers[3], "");
    EXPECT_EQ(answers[4], "");
    EXPECT_EQ(r.last.campaign->ended, 1U) << test::log_of(r);
}

TEST_F(CampaignHostTest, AStopPausesItAndResumeGoesOn) {
    const auto r = play(
        test::slow,
        {scan(), {measuring, give(End{})}, {waits, give(TellCampaign{campaign::Word::resume})}, until(ended)},
        120);
    EXPECT_EQ(answers, Answers(3, ""));
    EXPECT_EQ(r.last.campaign->ended, 3U) << test::log_of(r);
    for (const char* word : {"paused: by the operator", "resumed: by the operator"})
        EXPECT_TRUE(std::ranges::any_of(r.events, [&](const BenchEvent& e) {
            return e.kind == "campaign" && e.text == word;
        })) << test::log_of(r);
}

// At 5 Hz the usual 1 g of a return is beyond the limits of the bench.
TEST_F(CampaignHostTest, APlanOfOneHarmonicIsNotLimitedByAReturn) {
    bench::Bench bench = bench::open_bench("sim:", {}, simulated::World::Pace::lockstep);
    bench.response = [](double hz) { return hz > 300 ? std::complex{NAN, NAN} : std::complex{10.0, 0.0}; };
    campaign::Point low, high;
    low.asked.drive.frequency = 100;
    high.asked.drive.frequency = 200;
    const std::map<double, double> most = campaign::most_return_gamma({low, high}, bench);
    EXPECT_LT(most.at(100), 1000);
    EXPECT_EQ(most.at(200), INFINITY);
}

TEST_F(CampaignHostTest, ReturnsKeepWithinTheLimits) {
    std::string scene = test::slow;
    scene += "[walker]\nstart_mm = 35\n";
    const std::string plan =
        "[point]\nperiods = 10\nfrequency = 5\n[[series]]\ngamma = 3.5\nphi = [0, 0.3]\n";
    const auto r = play(scene, {{in(RunState::idle), give(MeasurePlan{"low", plan})}, until(ended)}, 300,
                        {0.113, 0.001});
    EXPECT_EQ(answers, Answers(1, "")) << test::log_of(r);
    EXPECT_EQ(r.last.campaign->ended, 2U) << test::log_of(r);
    EXPECT_EQ(r.last.trips, 0U);
    const campaign::PointsTable table = campaign::read_points(of(r) / campaign::table_name);
    for (const campaign::PointRow& row : table.points) EXPECT_EQ(row.outcome, "measured") << row.reason;
}

// The folder can be continued by "shakerd campaign --continue".
TEST_F(CampaignHostTest, AnAbortPausesItAndItCanBeEndedThere) {
    const auto r = play(test::slow,
                        {scan(),
                         {measuring, [](BenchPort& port) { port.abort("a test"); }},
                         {test::may_clear, give(ClearTrip{})},
                         {waits, give(TellCampaign{campaign::Word::stop})},
                         until(ended)},
                        120);
    EXPECT_EQ(answers, Answers(3, "")) << test::log_of(r);
    const campaign::StoredCampaign stored = campaign::read_campaign(of(r));
    EXPECT_EQ(stored.progress.campaign->what, campaign::CampaignChange::What::paused);
    EXPECT_FALSE(stored.progress.done(3));
}

TEST_F(CampaignHostTest, TheEndOfTheProgramLeavesItToBeContinued) {
    test::Move leave = until(measuring);
    leave.leaves = true;
    const auto r = play(test::slow, {scan(), leave}, 120);
    const campaign::StoredCampaign stored = campaign::read_campaign(of(r));
    EXPECT_EQ(stored.progress.campaign->what, campaign::CampaignChange::What::paused);
    EXPECT_TRUE(std::filesystem::exists(of(r) / campaign::table_name));
}

// A kill leaves no word in the journal: its first lines are what a daemon of that moment has written.
TEST_F(CampaignHostTest, TheNextDaemonTellsOfACampaignThatWasInterrupted) {
    const auto r = play(test::slow, {scan(), until(ended)}, 120);
    EXPECT_FALSE(play(test::slow, {until(in(RunState::idle))}, 20).last.campaign) << "it has ended";
    const std::filesystem::path journal = of(r) / campaign::journal_name;
    std::vector<std::string> lines;
    std::ifstream in{journal};
    for (std::string line; std::getline(in, line);) lines.push_back(line);
    for (std::size_t kept = 1; kept < lines.size(); ++kept) {
        std::ofstream out{journal};
        for (std::size_t i = 0; i < kept; ++i) out << lines[i] << '\n';
        out.close();
        const auto next =
            play(test::slow, {until([](const BenchState& s) { return s.campaign.has_value(); })}, 20);
        ASSERT_TRUE(next.last.campaign) << kept;
        const CampaignState& told = *next.last.campaign;
        EXPECT_EQ(told.doing, "interrupted");
        EXPECT_EQ(told.folder, r.last.campaign->folder);
        EXPECT_EQ(told.points, 3U);
        EXPECT_EQ(told.ended,
                  static_cast<std::size_t>(std::count_if(
                      lines.begin(), lines.begin() + static_cast<long>(kept),
                      [](const std::string& l) { return l.find("point ended") != std::string::npos; })));
        EXPECT_TRUE(std::ranges::any_of(next.events, [&](const BenchEvent& e) {
            return e.text == told.newest && e.text.find("--continue") != std::string::npos;
        })) << test::log_of(next);
    }
}

TEST_F(CampaignHostTest, WrongPlansAreRefusedAndNothingIsLeft) {
    const auto r = play(test::slow,
                        {{in(RunState::idle), give(MeasurePlan{"unknown"})},
                         {in(RunState::idle), give(MeasurePlan{"bad", "[[series]]\ngamma = \"40g\"\n"})},
                         {in(RunState::idle), give(MeasurePlan{"../up", "x"})},
                         {in(RunState::idle), give(TellCampaign{campaign::Word::pause})}},
                        20);
    ASSERT_EQ(answers.size(), 4U);
    test::expect_in(answers[0], {"plan \"unknown\"", "no such plan"});
    test::expect_in(answers[1], {"bad:2"});
    test::expect_in(answers[2], {"plan \"../up\"", "letters"});
    test::expect_in(answers[3], {"no campaign"});
    EXPECT_FALSE(r.last.campaign);
    for (const auto& entry : std::filesystem::directory_iterator{folder})
        EXPECT_FALSE(entry.is_directory()) << entry.path();
}

TEST(PlansTest, AreFoundByNameInsideTheirFolderOnly) {
    const std::filesystem::path folder = test::source_dir() + "/daemon/campaign/plans";
    const std::vector<std::string> names = campaign::plans_in(folder);
    EXPECT_NE(std::ranges::find(names, "fig3"), names.end());
    EXPECT_NE(campaign::plan_text(folder, "fig3").find("[[series]]"), std::string::npos);
    for (const char* name : {"../README", "fig3.toml", "", "/etc/passwd"})
        EXPECT_THROW((void)campaign::plan_text(folder, name), InputError) << name;
    EXPECT_TRUE(campaign::plans_in("/nowhere").empty());
}

}  // namespace
}  // namespace shaker::service

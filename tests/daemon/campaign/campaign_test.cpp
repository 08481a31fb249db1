// A whole campaign on the simulated bench: measured, continued, and reduced again.
#include "daemon/campaign/lead/campaign.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "daemon/campaign/campaign_folder.hpp"
#include "daemon/campaign/point_results.hpp"
#include "daemon/campaign/points_table.hpp"
#include "daemon/commands/campaign.hpp"
#include "drivers/errors.hpp"
#include "tests/support/program.hpp"

namespace shaker::campaign {
namespace {

constexpr const char* plan = R"(title = "three points"
[[series]]
name = "pair"
gamma = ["1g"]
phi = ["0deg"]
periods = 12
order = "mirror"
[[series]]
name = "other"
gamma = ["0.7g"]
phi = ["60deg"]
periods = 12
)";

class CampaignTest : public testing::Test {
protected:
    CampaignTest() {
        std::ofstream{folder_ / "plan.toml"} << plan;
        options_.plan = folder_ / "plan.toml";
        options_.folder = folder_ / "points";
        options_.run.standard = simulated::paper_scene(simulated::Detail::positions);
        options_.run.pictures = recorded::KeptPictures::off;
    }
    [[nodiscard]] PointsTable table() const { return read_points(options_.folder / table_name); }

    std::filesystem::path folder_ = test::fresh_folder();
    commands::CampaignOptions options_;
};

TEST_F(CampaignTest, MeasuresPlanAndReducesToTheBit) {
    std::ofstream{folder_ / "scene.toml"} << "gravity_mps2 = 9.83\n";
    options_.run.scene = folder_ / "scene.toml";
    measure_campaign(options_);
    const PointsTable points = table();
    EXPECT_EQ(points.gravity, 9.83);
    ASSERT_EQ(points.points.size(), 3U);
    for (const PointRow& row : points.points) {
        EXPECT_EQ(row.outcome, "measured") << row.reason;
        EXPECT_NEAR(row.v_D.value, row.true_v_D, 4 * row.v_D.sigma) << row.point;
        EXPECT_EQ(row.recording, "r001") << "one recording for all";
        EXPECT_GT(row.travel_m * row.v_D.value, 0) << "settling included";
    }
    EXPECT_EQ(points.points[1].partner, 1);
    EXPECT_TRUE(commands::reduce_campaign(options_.folder));
}

// As after a kill: the journal ends within the second point.
TEST_F(CampaignTest, ContinuesWithThePointInProgress) {
    measure_campaign(options_);
    const PointsTable whole = table();
    std::ifstream in{options_.folder / journal_name};
    std::string kept, line;
    for (int ended = 0; ended < 1 && std::getline(in, line); kept += line + "\n")
        ended += line.find("measured") != std::string::npos ? 1 : 0;
    in.close();
    std::ofstream{options_.folder / journal_name} << kept << R"({"time": "2026-11)";
    options_.plan.clear();
    measure_campaign(options_);
    const PointsTable points = table();
    for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_EQ(points.points[i].outcome, "measured") << points.points[i].reason;
        EXPECT_EQ(points.points[i].recording, i == 0 ? "r001" : "r002");
    }
    EXPECT_EQ(points.points[0].v_D.value, whole.points[0].v_D.value) << "not measured again";
}

// 3 mm from where a pass ends: the identification alone would walk it over the limit at the edge.
TEST_F(CampaignTest, WalkerNearTheEdgeIsMeasuredWithoutATrip) {
    std::ofstream{folder_ / "plan.toml"}
        << "[point]\nperiods = 20\n[[series]]\ngamma = \"0.408g\"\nphi = 4.2470\n";
    std::ofstream{folder_ / "scene.toml"} << "seed = 5\n[walker]\nstart_mm = -38.44639427297974\n"
                                             "[top]\nwidth_px = 318\n[side]\nwidth_px = 318\n";
    options_.run.scene = folder_ / "scene.toml";
    measure_campaign(options_);
    EXPECT_EQ(table().points.front().outcome, "measured") << table().points.front().reason;
}

// The plan has more points than mu needs. The journal has what was reached; --continue needs no more point.
TEST_F(CampaignTest, EndsWhenMuIsKnown) {
    std::ofstream{folder_ / "plan.toml"} << "stop_at = \"mu 0.5 %\"\n[point]\nperiods = 12\n[[series]]\n"
                                            "gamma = [\"0.7g\", \"1g\"]\norder = \"mirror\"\n"
                                            "phi = {from = 0, to = 2.5, steps = 5}\n";
    measure_campaign(options_);
    const PointsTable points = table();
    const auto measured = std::ranges::count(points.points, "measured", &PointRow::outcome);
    EXPECT_GE(measured, 4);
    EXPECT_LE(measured, 8);
    const law::CoulombFit fit = law::fit_coulomb(law_points(points));
    EXPECT_LT(fit.mu.error, 0.005 * fit.mu.value);
    EXPECT_NEAR(fit.mu.value, 0.113, 4 * fit.mu.error);
    const auto progress = read_campaign(options_.folder).progress;
    EXPECT_NE(progress.campaign->reason.find("target 0.5 %"), std::string::npos) << progress.campaign->reason;
    options_.plan.clear();
    measure_campaign(options_);
    EXPECT_EQ(std::ranges::count(table().points, "measured", &PointRow::outcome), measured);
}

// One camera states a scale that is 1 % too large: the doubt of each measurement reaches the fits of the
// campaign.
TEST_F(CampaignTest, AnAlarmOfTheBenchCheckReachesTheFits) {
    std::ofstream{folder_ / "scene.toml"} << "[side]\ntrue_mm_per_px = 0.396\n";
    options_.run.scene = folder_ / "scene.toml";
    measure_campaign(options_);
    for (const PointRow& row : table().points) {
        EXPECT_EQ(row.outcome, "measured") << row.reason;
        EXPECT_TRUE(row.doubt.starts_with("bench check: ")) << row.point << row.doubt;
    }
    EXPECT_TRUE(commands::reduce_campaign(options_.folder))
        << "doubts of recordings and of raw data are equal";
    const test::Outcome mu = test::shakerd("mu points", folder_);
    EXPECT_NE(mu.out.find("of 3 of 3 points are in doubt"), std::string::npos) << mu.out;
}

TEST_F(CampaignTest, FolderInUseIsRefused) {
    std::filesystem::create_directory(options_.folder);
    std::ofstream{options_.folder / "notes.txt"} << "mine";
    EXPECT_THROW(measure_campaign(options_), InputError);
    EXPECT_TRUE(std::filesystem::exists(options_.folder / "notes.txt"));
}

TEST_F(CampaignTest, PlanBeyondLimitsIsRefusedBeforeAnythingMoves) {
    std::ofstream{folder_ / "plan.toml"} << "title = \"x\"\n[[series]]\nname = \"far\"\ngamma = [\"40g\"]\n"
                                            "phi = [\"0deg\"]\nperiods = 12\n";
    try {
        measure_campaign(options_);
        FAIL();
    } catch (const InputError& e) {
        EXPECT_NE(std::string{e.what()}.find("plan.toml:4"), std::string::npos) << e.what();
    }
}

}  // namespace
}  // namespace shaker::campaign

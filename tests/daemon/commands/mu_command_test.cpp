#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>

#include "daemon/campaign/point_results.hpp"
#include "daemon/campaign/points_table.hpp"
#include "daemon/commands/mu.hpp"
#include "drivers/errors.hpp"
#include "tests/support/law/stepped_walker.hpp"
#include "tests/support/law/synthetic_points.hpp"
#include "tests/support/program.hpp"
#include "tests/support/recording/recording_folder.hpp"

namespace shaker::commands {
namespace {

campaign::PointsTable table_of(const std::vector<law::Point>& points) {
    campaign::PointsTable t;
    for (const law::Point& p : points) {
        campaign::PointRow row{
            .point = p.number, .partner = p.partner, .asked = p.asked, .outcome = "measured"};
        row.frequency = {p.frequency, 1e-6};
        row.gamma = p.gamma;
        row.rho = p.rho;
        row.phi = p.phi;
        row.v_D = p.v_D;
        row.periods = 40;
        row.frames = 4000;
        t.points.push_back(row);
        for (int q = 1; q <= max_harmonics; ++q) {
            campaign::PointHarmonic h{.point = p.number};
            h.measured.q = q;
            h.measured.amplitude = {std::abs(p.base.at(q)), 3e-4};
            h.measured.phase = {std::arg(p.base.at(q)), 1e-4};
            t.harmonics.push_back(h);
        }
        for (int i = 0; i < 100; ++i) t.cycle.push_back({.point = p.number, .phase = i / 100.0});
    }
    return t;
}

class MuCommandTest : public testing::Test {
protected:
    MuCommandTest() {
        campaign::write_points(folder_ / "campaign.nxs", "law", "",
                               table_of(test::exact_points({.mu = 0.113, .push = 0.1})));
    }
    const std::filesystem::path folder_ = test::fresh_folder();
};

TEST_F(MuCommandTest, PointsComeBackFromTheTable) {
    const auto points = campaign::law_points(campaign::read_points(folder_ / "campaign.nxs"), 3);
    ASSERT_EQ(points.size(), 12U);
    EXPECT_EQ(points[1].number, 2);
    EXPECT_EQ(points[1].partner, 1);
    EXPECT_EQ(points[1].campaign, 3);
    EXPECT_EQ(points[1].phases_per_period, 50);
    EXPECT_NEAR(law::fit_coulomb(points).mu.value, 0.113, 1e-6);
}

TEST_F(MuCommandTest, PrintsMuOfOneAndSeveralCampaigns) {
    const test::Outcome one = test::shakerd("mu . --json", folder_);
    ASSERT_EQ(one.status, 0) << one.err;
    const auto j = nlohmann::json::parse(one.out);
    EXPECT_NEAR(j.at("fits").at(0).at("value").get<double>(), 0.113, 1e-6);
    std::filesystem::create_directory(folder_ / "other");
    std::filesystem::copy_file(folder_ / "campaign.nxs", folder_ / "other/campaign.nxs");
    const test::Outcome two = test::shakerd("mu . other --level", folder_);
    EXPECT_EQ(two.status, 0) << two.err;
    EXPECT_NE(two.out.find("mu_ac"), std::string::npos);
    EXPECT_NE(two.out.find("of 24 points"), std::string::npos) << two.out;
    const test::Outcome same = test::shakerd("mu . campaign.nxs", folder_);
    EXPECT_EQ(same.status, 2);
    EXPECT_NE(same.err.find("campaign.nxs: its measurements are given twice"), std::string::npos) << same.err;
}

TEST_F(MuCommandTest, GravityIsThatOfTheBench) {
    campaign::PointsTable north = table_of(test::exact_points({.mu = 0.113, .g = 9.83}));
    north.gravity = 9.83;
    std::filesystem::create_directory(folder_ / "north");
    campaign::write_points(folder_ / "north" / "campaign.nxs", "law", "", north);
    const auto fitted = [&](const std::string& options) {
        const test::Outcome o = test::shakerd("mu north --json" + options, folder_);
        EXPECT_EQ(o.status, 0) << o.err;
        return nlohmann::json::parse(o.out);
    };
    EXPECT_EQ(fitted("").at("gravity_mps2"), 9.83);
    EXPECT_NEAR(fitted("").at("fits").at(0).at("value").get<double>(), 0.113, 1e-6);
    const double elsewhere = fitted(" --gravity 9.8m/s^2").at("fits").at(0).at("value");
    EXPECT_NEAR(elsewhere / 0.113 - 1, 9.83 / 9.8 - 1, 3e-4);
    const test::Outcome both = test::shakerd("mu . north", folder_);
    EXPECT_EQ(both.status, 2);
    EXPECT_NE(both.err.find("north/campaign.nxs: gravity is 9.83 m/s^2, 9.8 m/s^2 in"), std::string::npos)
        << both.err;
    EXPECT_EQ(test::shakerd("mu . north --gravity 9.8m/s^2", folder_).status, 0);
}

TEST_F(MuCommandTest, TablesOfBeforeAreRead) {
    const auto change = [&](const std::string& python) {
        const std::string command = "/usr/bin/python3 -c \"import h5py; e=h5py.File('" +
                                    (folder_ / "campaign.nxs").string() + "','r+')['entry']; " + python +
                                    "\"";
        EXPECT_EQ(std::system(command.c_str()), 0);
    };
    change(
        "[e['points'].pop(c) for c in ('doubt', 'tilt', 'tilt_errors')]; del "
        "e['process'].attrs['gravity_mps2']");
    const auto points = campaign::law_points(campaign::read_points(folder_ / "campaign.nxs"));
    EXPECT_NEAR(law::fit_coulomb(points).mu.value, 0.113, 1e-6);
    EXPECT_EQ(points.front().doubt, "");
    EXPECT_TRUE(std::isnan(points.front().tilt.value));
    change("del e['points/point']; e['points/point'] = 3.0");
    EXPECT_THROW(static_cast<void>(campaign::read_points(folder_ / "campaign.nxs")), InputError);
}

TEST_F(MuCommandTest, ADoubtReachesTheFits) {
    campaign::PointsTable t = table_of(test::exact_points({.mu = 0.113}));
    t.points[4].doubt = "bench check: the cameras disagree";
    campaign::write_points(folder_ / "doubt.nxs", "law", "", t);
    const std::string text = mu_text({folder_ / "doubt.nxs"}, {}, false);
    EXPECT_NE(text.find("of 1 of 12 points are in doubt, so is every fit. Point 5: bench check: the cameras"),
              std::string::npos)
        << text;
    const auto j = nlohmann::json::parse(mu_text({folder_ / "doubt.nxs"}, {}, true));
    EXPECT_EQ(j.at("points").at(4).at("doubt"), "bench check: the cameras disagree");
    EXPECT_EQ(j.at("points").at(3).at("doubt"), "");
}

TEST_F(MuCommandTest, OtherFilesAreRefusedByName) {
    std::ofstream{folder_ / "notes.nxs"} << "text";
    std::filesystem::create_directory(folder_ / "empty");
    for (const char* name : {"notes.nxs", "empty", "missing"}) {
        const test::Outcome o = test::shakerd(std::string{"mu "} + name, folder_);
        EXPECT_EQ(o.status, 2) << name;
        EXPECT_NE(o.err.find(name), std::string::npos) << o.err;
    }
    EXPECT_THROW(mu_text({folder_ / "notes.nxs"}, {}, false), InputError);
}

TEST_F(MuCommandTest, CampaignWithoutMeasuredPointsIsRefused) {
    campaign::PointsTable t = table_of(test::exact_points({.mu = 0.113}));
    for (auto& row : t.points) row.outcome = "failed";
    campaign::write_points(folder_ / "failed.nxs", "law", "", t);
    EXPECT_THROW(mu_text({folder_ / "failed.nxs"}, {}, false), InputError);
}

TEST_F(MuCommandTest, TimesAndPlacesOfThePointsComeBack) {
    campaign::PointsTable table = table_of(test::exact_points({.mu = 0.113}));
    table.points[0].time = "1970-01-01T00:00:10+00:00";
    table.points[1].time = "1970-01-01T02:00:00+02:00";
    table.passes.push_back({.point = 1, .pass = 1, .x_from_m = 0.01, .x_to_m = 0.02});
    table.passes.push_back({.point = 1, .pass = 2, .x_from_m = -0.01, .x_to_m = 0});
    campaign::write_points(folder_ / "placed.nxs", "law", "", table);
    const auto points = campaign::law_points(campaign::read_points(folder_ / "placed.nxs"));
    EXPECT_EQ(points[0].time_s, 10);
    EXPECT_EQ(points[1].time_s, 0);
    EXPECT_TRUE(std::isnan(points[2].time_s));
    EXPECT_NEAR(points[0].place, 0.005, 1e-15);
    EXPECT_TRUE(std::isnan(points[1].place));
}

// Where the data refuse Coulomb's law, the law that holds stands first and mu_ac is marked.
TEST_F(MuCommandTest, RefusedMuStandsBehindTheLawThatHolds) {
    law::LawSetting viscous;
    viscous.friction.viscous = 3.5;
    viscous.push = 0.1;
    campaign::write_points(folder_ / "viscous.nxs", "law", "",
                           table_of(test::stepped_points(viscous, 10'000)));
    const std::string file = folder_ / "viscous.nxs";
    const auto j = nlohmann::json::parse(mu_text({file}, {}, true));
    EXPECT_EQ(j["fits"][0]["name"], "mu_ac");
    EXPECT_EQ(j["fits"][0]["refused"], true);
    EXPECT_EQ(j["verdict"]["chosen"], "viscous");
    EXPECT_NEAR(j["verdict"]["laws"][2]["parameters"][0]["value"].get<double>(), 3.5, 0.02);
    const test::Outcome law = test::shakerd("law viscous.nxs --json", folder_);
    EXPECT_EQ(law.status, 0);
    auto found = nlohmann::json::parse(law.out);
    EXPECT_EQ(found["friction"], j["friction"]);
    EXPECT_EQ(found["friction_tilt"], j["friction_tilt"]);
    found.erase("friction");
    found.erase("friction_tilt");
    EXPECT_EQ(found, j["verdict"]);

    const auto coulomb = nlohmann::json::parse(mu_text({folder_ / "campaign.nxs"}, {}, true));
    EXPECT_EQ(coulomb["fits"][0]["refused"], false);
    EXPECT_TRUE(coulomb["verdict"].is_null());
}

}  // namespace
}  // namespace shaker::commands

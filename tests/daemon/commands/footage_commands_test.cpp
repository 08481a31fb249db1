// "shakerd reduce" and "shakerd track" on sessions of footage.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/support/paths.hpp"
#include "tests/support/program.hpp"
#include "tests/support/rms.hpp"
#include "tests/support/shared_data.hpp"

namespace shaker::commands {
namespace {

using nlohmann::json;
using test::fresh_folder;
using test::Outcome;
using test::rms_about_mean;
using test::shakerd;

const std::string sessions = test::source_dir() + "/tests/drivers/footage/sessions/";

struct Row {
    int frame = 0;
    double x_px = NAN, y_px = NAN, x_mm = NAN;
    std::string state;
};
using Tracks = std::map<std::string, std::vector<Row>>;  // "camera target"

Tracks read_tracks(const std::filesystem::path& csv) {
    std::ifstream in{csv};
    std::string line;
    std::getline(in, line);
    EXPECT_EQ(line, "camera,frame,t_s,target,x_px,y_px,sd_px,x_mm,state");
    Tracks tracks;
    while (std::getline(in, line)) {
        std::vector<std::string> f;
        std::stringstream words{line};
        for (std::string w; std::getline(words, w, ',');) f.push_back(w);
        Row r{.frame = std::stoi(f.at(1)), .state = f.at(8)};
        if (!f[4].empty()) {
            r.x_px = std::stod(f[4]);
            r.y_px = std::stod(f[5]);
            r.x_mm = std::stod(f[7]);
        }
        tracks[f[0] + " " + f[3]].push_back(r);
    }
    return tracks;
}

// A session written by "shakerd example", which needs no shared data.
TEST(ExampleSessionTest, ReducesToItsTruthWithinErrors) {
    const auto folder = fresh_folder();
    const Outcome written = shakerd("example lab", folder);
    ASSERT_EQ(written.status, 0) << written.err;
    EXPECT_EQ(written.out, "lab/session.toml\n");
    const Outcome o = shakerd("reduce --json lab/session.toml", folder);
    ASSERT_EQ(o.status, 0) << o.err;
    const json r = json::parse(o.out), truth = json::parse(std::ifstream{folder / "lab/truth.json"});
    const double v_D = truth["v_D_mps"], se = r["v_D_se_mps"];
    EXPECT_NEAR(v_D, 0.0146, 3e-4)
        << "exact Coulomb at 1 g, phi 0: 14.58 mm/s; the base is not corrected here";
    EXPECT_NEAR(r["v_D_mps"].get<double>(), v_D, 3 * se);
    EXPECT_LT(se, 2e-3 * v_D);
    EXPECT_NEAR(r["gamma_mps2"].get<double>(), 9.8, 0.2);
    EXPECT_EQ(r["frames_lost"], 0);
    EXPECT_EQ(r["frames"], 2 * 240);
}

TEST(ExampleSessionTest, IsSmallAndOverwritesNothing) {
    const auto folder = fresh_folder();
    ASSERT_EQ(shakerd("example lab", folder).status, 0);
    std::uintmax_t bytes = 0;
    int files = 0;
    for (const auto& entry : std::filesystem::directory_iterator{folder / "lab"}) {
        bytes += entry.file_size();
        ++files;
    }
    EXPECT_EQ(files, 5);
    EXPECT_LT(bytes, 30'000'000U);
    const Outcome again = shakerd("example lab", folder);
    EXPECT_EQ(again.status, 2);
    EXPECT_NE(again.err.find("session.toml: exists already"), std::string::npos) << again.err;
}

class SessionTest : public testing::Test {
protected:
    void SetUp() override {
        if (shared_data("lab-session").empty()) GTEST_SKIP() << missing_data("lab-session");
    }
};

TEST_F(SessionTest, LabSessionGivesTruthAndReplays) {
    const json truth = json::parse(std::ifstream{shared_data("lab-session") / "truth.json"});
    const auto folder = fresh_folder();
    const Outcome o = shakerd("reduce --json -o out.nxs " + sessions + "lab-session.toml", folder);
    ASSERT_EQ(o.status, 0) << o.err;
    const json r = json::parse(o.out);
    const auto got = [&](const char* key) { return r[key].get<double>(); };
    EXPECT_NEAR(got("v_D_mps") / (1e-3 * truth["v_D_mmps"].get<double>()), 1, 0.01);
    EXPECT_LE(std::abs(got("v_D_mps") - 1e-3 * truth["v_D_mmps"].get<double>()), 3 * got("v_D_se_mps"));
    EXPECT_NEAR(got("D_m") / (1e-3 * truth["D_mm"].get<double>()), 1, 0.01);
    EXPECT_NEAR(got("accelerometer_late_s"), truth["accel_late_s"].get<double>(), 100e-6);
    EXPECT_LE(std::abs(got("accelerometer_ppm") - truth["ppm"].get<double>()),
              3 * got("accelerometer_ppm_se"));
    EXPECT_NEAR(got("gamma_mps2") / truth["gamma_mps2"].get<double>(), 1, 0.01);
    EXPECT_NEAR(got("phi_rad"), truth["phi_rad"].get<double>(), 0.010);
    EXPECT_NEAR(got("rho"), 0.5, 0.005);
    EXPECT_NEAR(got("efficiency") / truth["efficiency"].get<double>(), 1, 0.01);
    const auto third = std::ranges::find_if(r["harmonics"], [](const json& h) { return h["q"] == 3; });
    ASSERT_NE(third, r["harmonics"].end());
    EXPECT_GT((*third)["amplitude_mps2"].get<double>(), 10 * (*third)["amplitude_se_mps2"].get<double>());
    EXPECT_EQ(r["frames"], 600);
    const Outcome replay = shakerd("replay out.nxs", folder);
    EXPECT_EQ(replay.status, 0) << replay.err << replay.out;
}

TEST_F(SessionTest, LabTracksLieOnTheExactPositions) {
    const json truth = json::parse(std::ifstream{shared_data("lab-session") / "truth.json"});
    const auto folder = fresh_folder();
    const Outcome o = shakerd("track -o tracks.csv " + sessions + "lab-session.toml", folder);
    ASSERT_EQ(o.status, 0) << o.err;
    const Tracks tracks = read_tracks(folder / "tracks.csv");
    ASSERT_EQ(tracks.size(), 4U);
    for (const auto& [name, rows] : tracks) {
        ASSERT_EQ(rows.size(), 300U) << name;
        const bool walker = name.find("walker") != std::string::npos;
        const json& exact = truth[walker ? "x_walker_mm_every_frame" : "x_base_mm_every_frame"];
        std::vector<double> off;
        for (const Row& row : rows)
            off.push_back(row.x_mm - exact[static_cast<std::size_t>(row.frame)].get<double>());
        const double px = rms_about_mean(off) / 0.25;
        RecordProperty(name + " rms px", std::to_string(px));
        EXPECT_LE(px, 0.02) << name;
    }
}

TEST_F(SessionTest, DotsOfSwingingBuildingKeepIdentity) {
    const auto folder = fresh_folder();
    const Outcome o = shakerd("track -o tracks.csv " + sessions + "building-swing.toml", folder);
    ASSERT_EQ(o.status, 0) << o.err;
    const Tracks tracks = read_tracks(folder / "tracks.csv");
    ASSERT_EQ(tracks.size(), 14U);
    for (const std::string camera : {"top", "bottom"}) {
        for (int dot = 1; dot < 7; ++dot) {
            const auto& a = tracks.at(camera + " dot" + std::to_string(dot));
            const auto& b = tracks.at(camera + " dot" + std::to_string(dot + 1));
            ASSERT_EQ(a.size(), 160U);
            std::vector<double> distance;
            for (std::size_t k = 0; k < 160; ++k)
                if (a[k].state != "lost" && b[k].state != "lost")
                    distance.push_back(std::hypot(b[k].x_px - a[k].x_px, b[k].y_px - a[k].y_px));
            ASSERT_GT(distance.size(), 100U);
            // Rigid beams: a mix-up with the neighbour would be 160 px off, with another mark tens of px.
            const auto [least, most] = std::ranges::minmax(distance);
            EXPECT_LT(most - least, 5) << camera << " dot " << dot;
            // The camera looks at the swinging top beam obliquely: its gaps change with its place by up
            // to 2.7 px.
            EXPECT_LT(rms_about_mean(distance), camera == "top" ? 1.0 : 0.08) << camera << " dot " << dot;
        }
    }
}

TEST_F(SessionTest, HighSpeedCamerasFilesAreTracked) {
    for (const auto& [name, frames] : {std::pair{"photron", 75}, {"phantom", 235}}) {
        const Outcome o = shakerd(std::string{"track --json "} + sessions + name + ".toml", fresh_folder());
        ASSERT_EQ(o.status, 0) << o.err;
        const json r = json::parse(o.out);
        EXPECT_EQ(r["frames"], frames);
        for (const json& t : r["targets"]) EXPECT_LE(t["frames_lost"].get<int>(), 2) << t;
    }
}

// From a movie to tracks without a line by hand; nothing is overwritten.
TEST(ProposedSessionTest, IsTrackedAsItIsWritten) {
    const auto folder = fresh_folder();
    ASSERT_EQ(shakerd("example lab", folder).status, 0);
    for (const std::string view : {"top", "side"}) {
        const std::string init = "track --init lab/" + view + ".mkv -o " + view + ".toml";
        Outcome o = shakerd(init, folder);
        ASSERT_EQ(o.status, 0) << o.err;
        o = shakerd("track --json " + view + ".toml", folder);
        ASSERT_EQ(o.status, 0) << o.err;
        const json r = json::parse(o.out);
        ASSERT_GE(r["targets"].size(), view == "top" ? 2U : 1U) << o.out;
        for (const json& t : r["targets"]) EXPECT_EQ(t["frames_lost"], 0) << t;
        o = shakerd(init, folder);
        EXPECT_EQ(o.status, 2);
        EXPECT_NE(o.err.find(view + ".toml"), std::string::npos) << o.err;
    }
    Outcome o = shakerd("track --init lab/accelerations.csv", folder);
    EXPECT_EQ(o.status, 2) << o.err;
    o = shakerd("track --preview lab.jpg lab/session.toml", folder);
    ASSERT_EQ(o.status, 0) << o.err;
    std::ifstream picture{folder / "lab.jpg", std::ios::binary};
    EXPECT_EQ(picture.get(), 0xFF);
    EXPECT_EQ(picture.get(), 0xD8);
    EXPECT_GT(std::filesystem::file_size(folder / "lab.jpg"), 2000U);
}

// A session of the shared data with one thing changed.
Outcome changed(const std::string& from, const std::string& to, const std::filesystem::path& folder,
                const std::string& command = "reduce --json -o x.nxs") {
    std::ifstream in{sessions + "lab-session.toml"};
    std::ostringstream text;
    text << in.rdbuf();
    std::string toml = text.str();
    const std::string data = "../../../shared/data/lab-session";
    for (std::size_t at; (at = toml.find(data)) != std::string::npos;)
        toml.replace(at, data.size(), shared_data("lab-session").string());
    const std::size_t at = toml.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    if (at != std::string::npos) toml.replace(at, from.size(), to);
    std::ofstream{folder / "session.toml"} << toml;
    return shakerd(command + " session.toml", folder);
}

TEST_F(SessionTest, RefusesTargetOutsideItsRegion) {
    const auto folder = fresh_folder();
    std::ifstream in{sessions + "lab-session.toml"};
    std::string toml{std::istreambuf_iterator<char>{in}, {}};
    const std::size_t at = toml.find("roi_px");
    const std::string line = toml.substr(at, toml.find('\n', at) - at);
    const Outcome o = changed(line, "roi_px = [2, 100, 30, 30]", folder);
    EXPECT_EQ(o.status, 2);
    for (const char* named : {"top", "walker", "2, 100, 30, 30"})
        EXPECT_NE(o.err.find(named), std::string::npos) << o.err;
    EXPECT_FALSE(std::filesystem::exists(folder / "x.nxs") || std::filesystem::exists(folder / "x.nxs.part"));
}

TEST_F(SessionTest, RefusesFewerThanTwoCommonPeriods) {
    const auto folder = fresh_folder();
    for (const auto& [from, to] : {std::pair{"frequency_hz = 20.0", "frequency_hz = 5.0"},
                                   {"first_exposure_s = 0.00015", "first_exposure_s = 100.0"}}) {
        const Outcome o = changed(from, to, folder);
        EXPECT_EQ(o.status, 2) << to << o.err;
        EXPECT_NE(o.err.find("period"), std::string::npos) << o.err;
        EXPECT_FALSE(std::filesystem::exists(folder / "x.nxs") ||
                     std::filesystem::exists(folder / "x.nxs.part"));
    }
}

TEST_F(SessionTest, ReduceNeedsDriveAccelerometerWalkerAndBase) {
    const auto folder = fresh_folder();
    EXPECT_EQ(changed("name = \"walker\"", "name = \"wanderer\"", folder, "track").status, 0);
    for (const char* name : {"[drive]", "[accelerometer]"}) {
        const Outcome o = changed(name, "[[camera]]\n", folder);
        EXPECT_EQ(o.status, 2) << name << o.err;
    }
}

}  // namespace
}  // namespace shaker::commands

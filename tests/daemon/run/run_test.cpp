// "shakerd run" from outside.
#include <gtest/gtest.h>

#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <sstream>

#include "tests/support/nightly.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/program.hpp"

namespace shaker::run {
namespace {

using nlohmann::json;
using test::fresh_folder;
using test::Outcome;
using test::shakerd;

std::string scene(const std::string& name) {
    return " --scene '" + test::source_dir() + "/tests/support/" + name + ".toml' ";
}
// Rendered pictures, a fifth of the paper's.
const std::string slow_cameras = scene("slow_cameras");
// For tests that are not about pixels: neither rendering nor tracking.
const std::string position_cameras = scene("position_cameras");
constexpr const char* positions = "[top]\npositions = 1\n[side]\npositions = 1\n";

// Fewer periods with sanitisers, which make the program ten times slower.
const std::string paper_periods = SHAKER_SANITIZED ? "8" : "40";

std::string bytes(const std::filesystem::path& file) {
    std::ifstream in{file, std::ios::binary};
    std::ostringstream text;
    text << in.rdbuf();
    return text.str();
}

json run(const std::string& arguments, const std::filesystem::path& folder) {
    const Outcome o = shakerd("run --json " + arguments, folder);
    EXPECT_EQ(o.status, 0) << o.err;
    return json::parse(o.out);
}

void expect_true_drift(const json& r, double errors = 3) {
    const double v = r["v_D_mps"], se = r["v_D_se_mps"], truth = r["v_D_true_mps"];
    EXPECT_LE(std::abs(v - truth), errors * se) << "truth " << truth;
    EXPECT_LE(std::abs(v - truth), 0.01 * std::abs(truth));
    EXPECT_GT(se, 0);
}

// With rendered pictures, nightly at the paper's rate.
TEST(RunTest, PaperDriveGivesTrueDriftAndReplays) {
    const auto folder = fresh_folder();
    const json r =
        run("--periods " + paper_periods + (test::nightly() && !SHAKER_SANITIZED ? "" : slow_cameras) +
                " --frames region -o run.nxs",
            folder);
    expect_true_drift(r);
    EXPECT_NEAR(r["v_D_true_mps"].get<double>(), 14.5824e-3,
                0.01 * 14.5824e-3);  // the paper's drive, exact Coulomb
    EXPECT_NEAR(r["gamma_mps2"].get<double>(), 9.8, 2e-3 * 9.8);
    EXPECT_NEAR(r["phi_rad"].get<double>(), 0, 3e-3);
    EXPECT_EQ(r["frames_lost"], 0);
    const Outcome replay = shakerd("replay run.nxs", folder);
    EXPECT_EQ(replay.status, 0) << replay.err;
    EXPECT_NE(replay.out.find("replay: identical"), std::string::npos) << replay.out;
    EXPECT_FALSE(std::filesystem::exists(folder / "run.nxs.part"));
}

// One axis, no gravity. A pole at f_c leads by f_c / (q f) at harmonic q: phi = alpha_2 - 2 alpha_1 is read
// too small by 3/2 f_c / f. Without a told corner the control loop turns the drive by as much, v_D is that of
// another phi, and the cameras tell which; with one the base moves as asked.
TEST(RunTest, AnAcCoupledSensorWithOneAxisMeasures) {
    const auto predicted = [](double phi) {
        const Outcome o =
            shakerd("predict --json --gamma 1g --mu 0.113 --phi " + std::to_string(phi) + "rad", ".");
        return json::parse(o.out).at("v_D_mps").get<double>();
    };
    double without = 0;
    for (const auto& [corner_hz, told_hz] :
         {std::pair{0.0, -1.0}, {0.05, -1.0}, {0.33, -1.0}, {0.33, 0.33}}) {
        const auto folder = fresh_folder();
        std::ofstream{folder / "analog.toml"}
            << positions
            << "[accelerometer]\naxes = 1\ngravity = 0\nyaw_deg = 0\nhigh_pass_hz = " << corner_hz
            << "\ntold_high_pass_hz = " << told_hz << "\n";
        const json r = run("--scene analog.toml --gamma 1g --phi 0.6rad --periods 40 -o run.nxs", folder);
        expect_true_drift(r);
        EXPECT_TRUE(r.at("bench_check").at("tilt_rad").is_null());
        EXPECT_FALSE(r.at("bench_check").at("alarm"));
        EXPECT_EQ(shakerd("replay run.nxs", folder).status, 0);
        const double v = r["v_D_true_mps"], phi = r["phi_rad"], hz = r["accelerometer_corner_hz"];
        if (corner_hz == 0) without = v;
        const double turned = told_hz > 0 ? 0 : 1.5 * corner_hz / 20,
                     by_phi = predicted(0.6 + turned) - predicted(0.6);
        std::printf(
            "corner %.2f Hz, told %+.2f: found %.3f; phi is off by %.2f mrad, %.2f measured, v_D by %+.1f "
            "um/s (%+.1f by that phi)\n",
            corner_hz, told_hz, hz, 1e3 * turned, 1e3 * (phi - 0.6), 1e6 * (v - without), 1e6 * by_phi);
        EXPECT_NEAR(v - without, by_phi, 0.15 * std::abs(by_phi) + 2e-6);
        EXPECT_NEAR(phi, 0.6 + turned, 3 * r["phi_se_rad"].get<double>());
        EXPECT_NEAR(hz, corner_hz, 3 * r["accelerometer_corner_se_hz"].get<double>());
    }
}

// AC coupling, the walker's reaction and distortion of the shaker make the base's motion differ from the
// requested drive.
TEST(RunTest, OnlyClosedLoopGivesDriftOfRequestedDrive) {
    const auto folder = fresh_folder();
    const auto off = [&](const std::string& loop) {
        const json r =
            run("--gamma 1g --phi 35deg --periods " + paper_periods + position_cameras + loop, folder);
        const double asked = r["v_D_asked_mps"], v = r["v_D_mps"];
        std::printf("%-12s v_D %.4f mm/s, the asked drive gives %.4f: %+.3f %%\n", loop.c_str(), 1e3 * v,
                    1e3 * asked, 100 * (v / asked - 1));
        return std::abs(v / asked - 1);
    };
    EXPECT_LT(off(""), 0.005);
    EXPECT_GT(off(" --open-loop"), 0.01);
}

TEST(RunTest, TheSameSeedGivesTheSameBytes) {
    const auto folder = fresh_folder();
    run("--no-identify --periods 6 -o a.nxs" + slow_cameras, folder);
    run("--no-identify --periods 6 -o b.nxs" + slow_cameras, folder);
    EXPECT_TRUE(bytes(folder / "a.nxs") == bytes(folder / "b.nxs"));
    std::ofstream{folder / "seed.toml"}
        << "seed = 9\n[top]\nframe_rate_hz = 200\n[side]\nframe_rate_hz = 200\n";
    run("--no-identify --periods 6 --scene seed.toml -o c.nxs", folder);
    EXPECT_FALSE(bytes(folder / "a.nxs") == bytes(folder / "c.nxs"));
}

TEST(RunTest, ReplayDetectsChangedRecording) {
    const auto folder = fresh_folder();
    run("--no-identify --periods 4 --frames off -o run.nxs" + position_cameras, folder);
    EXPECT_EQ(shakerd("replay run.nxs", folder).status, 0);
    const std::string change =
        "/usr/bin/python3 -c \"import h5py,sys; f=h5py.File(sys.argv[1],'r+'); "
        "f['entry/raw/accelerometer/counts'][::7,0]+=1\" '" +
        (folder / "run.nxs").string() + "'";
    ASSERT_EQ(std::system(change.c_str()), 0);
    const Outcome o = shakerd("replay run.nxs", folder);
    EXPECT_EQ(o.status, 4);
    EXPECT_NE(o.out.find("NOT identical"), std::string::npos);
    EXPECT_NE(o.err.find("results/"), std::string::npos) << o.err;
}

TEST(RunTest, HarderScenesGiveTheirTrueDriftToo) {
    const auto folder = fresh_folder();
    std::ofstream{folder / "hard.toml"}
        << "seed = 5\ntilt_deg = 0.2\n[walker]\nmu_k = 0.15\nmu_s = 0.2\nstart_mm = -30\n"
           "[accelerometer]\nclock_ppm = -80\nyaw_deg = 33\n"
           "[top]\nframe_rate_hz = 200\nnoise_dn = 4\n[side]\nframe_rate_hz = 200\nalong_x = -1.0\n";
    expect_true_drift(run("--scene hard.toml --gamma 0.8g --phi 20deg --periods 20", folder));
    expect_true_drift(run(
        "--no-identify --scene hard.toml --gamma 1.2g --phi 80deg --rho 0.6 --frequency 25Hz --periods 20",
        folder));
}

// As with real cameras: times of frames follow from stamps, and from the recorded stamps on replay.
TEST(RunTest, CamerasWithOwnClocksReplayToTheBit) {
    const auto folder = fresh_folder();
    std::ofstream{folder / "clocks.toml"} << "[top]\npositions = 1\nown_clock = 1\nclock_ppm = 30\n"
                                             "[side]\npositions = 1\nown_clock = 1\nclock_ppm = -45\n";
    expect_true_drift(run("--no-identify --scene clocks.toml --periods 8 -o run.nxs", folder));
    const Outcome replay = shakerd("replay run.nxs", folder);
    EXPECT_EQ(replay.status, 0) << replay.err;
    EXPECT_NE(replay.out.find("replay: identical"), std::string::npos) << replay.out;
}

// Threads begin the measurement in one of some ten periods, so each run is another draw of the noise. With
// the seed of this scene 4 of 150 runs of ten periods were 3.2 errors off, of 60 runs of forty none more
// than 2.8.
TEST(RunTest, ThreadsGiveSameResultAsLockstep) {
    const auto folder = fresh_folder();
    expect_true_drift(run("--no-identify --periods 40 --threads -o threads.nxs" + position_cameras, folder),
                      4);
    EXPECT_EQ(shakerd("replay threads.nxs", folder).status,
              0);  // a recording made with threads replays in lockstep
}

TEST(RunTest, SymmetricDrivesDoNotDrift) {
    const json r = run("--no-identify --rho 1 --gamma 0.8g --periods 20" + position_cameras, fresh_folder());
    EXPECT_LE(std::abs(r["v_D_mps"].get<double>()), 3 * r["v_D_se_mps"].get<double>() + 2e-5);
}

TEST(RunTest, OptionsOverrideSettingsFile) {
    const auto folder = fresh_folder();
    std::ofstream{folder / "run.toml"}
        << "[run]\ngamma_mps2 = 6\nphi_rad = 0.3\nperiods = 4\nframes = \"off\"\n";
    const json r = run("--no-identify --settings run.toml --phi 0.2 -o a.nxs" + position_cameras, folder);
    EXPECT_NEAR(r["gamma_mps2"].get<double>(), 6, 0.02);
    EXPECT_NEAR(r["phi_rad"].get<double>(), 0.2, 0.01);
    EXPECT_NEAR((r["to_s"].get<double>() - r["from_s"].get<double>()) * 20, 4, 1e-3);
    std::ofstream{folder / "bad.toml"} << "[run]\ngamma_mps2 = 6\nphi_deg = 3\n";
    const Outcome o = shakerd("run --settings bad.toml", folder);
    EXPECT_EQ(o.status, 2);
    EXPECT_NE(o.err.find("bad.toml:3: run.phi_deg"), std::string::npos) << o.err;
}

TEST(RunTest, AClippingSensorStopsTheDrive) {
    const auto folder = fresh_folder();
    // Limits beyond the sensor's range, so that only the saturation check can trip.
    std::ofstream{folder / "clip.toml"} << positions
                                        << "[accelerometer]\nrange_mps2 = 10.5\n[limits]\n"
                                           "acceleration_abort_mps2 = 30\nsensor_range_mps2 = 10.5\n";
    const Outcome o = shakerd("run --no-identify --scene clip.toml --gamma 1.3g --periods 3", folder);
    EXPECT_EQ(o.status, 5);
    EXPECT_NE(o.err.find("sensor_saturated"), std::string::npos) << o.err;
}

// With the checks of the walker switched off in the limits.
TEST(RunTest, LostWalkerIsReducedFromSeenFramesWithNote) {
    const auto folder = fresh_folder();
    std::ofstream{folder / "wide.toml"} << positions
                                        << "[limits]\nedge_mm = -100\ntracking_lost_frames = 100000\n";
    const json r = run("--no-identify --scene wide.toml --gamma 2.7g --periods 20", folder);
    expect_true_drift(r);
    const int used = r["frames"], lost = r["frames_lost"];
    EXPECT_GT(lost, 100);
    EXPECT_NEAR(used + lost, 2 * 20 * 50, 4);  // two views, 50 frames a period
}

TEST(RunTest, WalkerNearEdgeOrLostStopsDrive) {
    const auto folder = fresh_folder();
    const Outcome edge = shakerd("run --no-identify --gamma 3g --periods 20" + position_cameras, folder);
    EXPECT_EQ(edge.status, 5);
    EXPECT_NE(edge.err.find("walker_edge"), std::string::npos) << edge.err;
    std::ofstream{folder / "wide.toml"} << positions << "[limits]\nedge_mm = -100\n";
    const Outcome lost = shakerd("run --no-identify --scene wide.toml --gamma 3g --periods 20", folder);
    EXPECT_EQ(lost.status, 5);
    EXPECT_NE(lost.err.find("tracking_lost"), std::string::npos) << lost.err;
}

TEST(RunTest, DriveNeedsPicturesOfTheWalker) {
    const auto folder = fresh_folder();
    const auto run_with = [&](const std::string& limits, double at_s, double for_s,
                              const std::string& camera) {
        std::ofstream{folder / "stall.toml"} << positions << limits
                                             << "[[fault]]\nwhat = \"camera_stall\"\nat_s = " << at_s
                                             << "\nfor_s = " << for_s << "\n"
                                             << camera;
        return shakerd("run --no-identify --scene stall.toml --gamma 0.7g --periods 4", folder);
    };
    const std::string strict = "[limits]\ncamera_missing_s = 0.1\n";
    for (const char* camera : {"camera = \"side\"\n", "camera = \"top\"\n"})
        EXPECT_EQ(run_with(strict, 2, 1000, camera).status, 0) << camera;
    EXPECT_EQ(run_with("", 2, 0.2, "").status, 0);
    EXPECT_EQ(run_with("", 0, 2, "").status, 0) << "cameras that start after the DAC";
    for (const Outcome& o :
         {run_with("", 0, 1000, ""), run_with("", 2, 1000, ""), run_with(strict, 2, 0.2, "")}) {
        EXPECT_EQ(o.status, 5);
        EXPECT_NE(o.err.find("camera_missing"), std::string::npos) << o.err;
    }
}

TEST(RunTest, CoveredWalkerStopsDrive) {
    const auto folder = fresh_folder();
    std::ofstream{folder / "hand.toml"} << "[top]\nframe_rate_hz = 200\n[side]\nframe_rate_hz = 200\n"
                                           "[[fault]]\nwhat = \"walker_hidden\"\nat_s = 2\n";
    const Outcome o = shakerd("run --no-identify --scene hand.toml --gamma 0.7g --periods 4", folder);
    EXPECT_EQ(o.status, 5);
    EXPECT_NE(o.err.find("tracking_lost"), std::string::npos) << o.err;
}

// The DAC triggers the cameras: without it no picture comes.
TEST(RunTest, ASilentDacIsNoSilenceOfTheCameras) {
    const auto folder = fresh_folder();
    std::ofstream{folder / "silent.toml"} << "[top]\nframe_rate_hz = 200\n[side]\nframe_rate_hz = 200\n"
                                             "[[fault]]\nwhat = \"underrun\"\nvalue = 72000\nat_s = 3\n";
    const Outcome o = shakerd("run --no-identify --scene silent.toml --gamma 0.7g --periods 20", folder);
    EXPECT_EQ(o.status, 0) << o.err;
    EXPECT_NE(o.err.find("was silent for 15"), std::string::npos) << o.err;
}

TEST(RunTest, DriveBeyondLimitsIsRefusedWithFigures) {
    const auto folder = fresh_folder();
    std::ofstream{folder / "weak.toml"} << "[shaker]\namplifier_gain = 1.0\n";
    const Outcome o = shakerd("run --scene weak.toml --gamma 2g --phi 0.5 --periods 4 -o x.nxs", folder);
    EXPECT_EQ(o.status, 2);
    EXPECT_NE(o.err.find("drive peak 2.269 V (limit 1 V); at most gamma 8.638 m/s^2 (0.88 g)"),
              std::string::npos)
        << o.err;
    EXPECT_FALSE(std::filesystem::exists(folder / "x.nxs"));
}

// The amplifier gives less than its data sheet.
TEST(RunTest, VoltageLimitKeepsShapeAndReportsReachedShare) {
    const auto folder = fresh_folder();
    std::ofstream{folder / "weak.toml"}
        << positions
        << "[[fault]]\nwhat = \"amplifier_gain\"\nvalue = 0.5\nat_s = 0\n[shaker]\namplifier_gain = 2.4\n"
           "[walker]\nstart_mm = -30\n";
    const json r = run("--scene weak.toml --gamma 2g --phi 0.5 --periods 4", folder);
    EXPECT_LT(r["gamma_mps2"].get<double>(), 0.9 * 19.6);
    EXPECT_NEAR(r["phi_rad"].get<double>(), 0.5, 0.01);
    EXPECT_NEAR(r["rho"].get<double>(), 0.5, 0.005);
    EXPECT_NE(r["notes"].dump().find("% of the requested gamma"), std::string::npos) << r["notes"];
}

TEST(RunTest, BadInputIsRefusedWithStatus2) {
    const auto folder = fresh_folder();
    std::ofstream{folder / "bad.toml"} << "[walker]\nmu = 0.1\n";
    const std::pair<const char*, const char*> cases[] = {
        {"run --gamma 1.5Hz -o x.nxs", "--gamma"},
        {"run --gamma 900g -o x.nxs", "--gamma"},
        {"run --gamma nan -o x.nxs", "--gamma"},
        {"run --phi 35m -o x.nxs", "--phi"},
        {"run --rho 1.5 -o x.nxs", "--rho"},
        {"run --frequency 0Hz -o x.nxs", "--frequency"},
        {"run --periods 1 -o x.nxs", "periods"},
        {"run --rig hw: -o x.nxs", "hw:"},
        {"run --scene none.toml -o x.nxs", "none.toml"},
        {"run --scene bad.toml -o x.nxs", "walker.mu"},
        {"run --no-such-option", "--no-such-option"},
        {"replay none.nxs", "none.nxs"},
        {"replay bad.toml", "bad.toml"},
        {"frobnicate", "frobnicate"},
        {"", "expected a command"},
        {"predict --mu -1", "--mu"},
        {"predict --json none.json", "none.json"},
        {"reduce none.toml", "none.toml"},
        {"track bad.toml -o x.csv", "bad.toml"},
    };
    for (const auto& [arguments, named] : cases) {
        const Outcome o = shakerd(arguments, folder);
        EXPECT_EQ(o.status, 2) << arguments << "\n" << o.err;
        EXPECT_NE((o.err + o.out).find(named), std::string::npos) << arguments << "\n" << o.err;
        EXPECT_FALSE(std::filesystem::exists(folder / "x.nxs") ||
                     std::filesystem::exists(folder / "x.nxs.part"));
    }
    EXPECT_FALSE(std::filesystem::exists(folder / "x.csv"));
}

TEST(RunTest, UnwritableDiskIsDeviceErrorWithFileName) {
    const auto folder = fresh_folder();
    const std::string name = std::string(300, 'x') + ".nxs";  // longer than file systems allow
    const Outcome o = shakerd("run --periods 3 -o " + name, folder);
    EXPECT_EQ(o.status, 3);
    EXPECT_NE(o.err.find(name), std::string::npos) << o.err;
}

TEST(RunTest, MissingFolderIsRefusedWithTheNextStep) {
    const Outcome o = shakerd("run --periods 3 -o no/such/folder/x.nxs", fresh_folder());
    EXPECT_EQ(o.status, 2);
    EXPECT_NE(o.err.find("no/such/folder/x.nxs: there is no folder no/such/folder; make it first"),
              std::string::npos)
        << o.err;
}

TEST(RunTest, TooFewPicturesAPeriodAreRefusedBeforeTheDrive) {
    const auto folder = fresh_folder();
    std::ofstream{folder / "slow.toml"} << "[top]\nframe_rate_hz = 60\n[side]\nframe_rate_hz = 60\n";
    const Outcome o = shakerd("run --scene slow.toml -o x.nxs", folder);
    EXPECT_EQ(o.status, 2);
    EXPECT_NE(
        o.err.find("camera \"top\" takes 3 pictures a period of the walker and 5 are needed; with its 60 "
                   "pictures/s at most 12 Hz is allowed"),
        std::string::npos)
        << o.err;
    EXPECT_EQ(o.err.find("identification"), std::string::npos) << "nothing is driven";
    EXPECT_EQ(shakerd("run --scene slow.toml --frequency 12Hz --gamma 0.5g --periods 20", folder).status, 0);
}

TEST(RunTest, HelpListsCommandsAndExitStatuses) {
    const Outcome o = shakerd("--help", fresh_folder());
    EXPECT_EQ(o.status, 0);
    for (const char* word : {"run", "replay", "reduce", "track", "predict", "Exit status"})
        EXPECT_NE(o.out.find(word), std::string::npos) << word;
}

}  // namespace
}  // namespace shaker::run

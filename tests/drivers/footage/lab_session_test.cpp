#include "drivers/footage/lab_session.hpp"

#include <cmath>

#include "drivers/quantity.hpp"
#include "tests/support/recording/recording_folder.hpp"

namespace shaker::footage {
namespace {

using namespace test;

constexpr int frames = 4;

/// A valid session; tests replace parts of its description.
class LabSessionTest : public ::testing::Test {
protected:
    LabSessionTest() {
        for (int k = 0; k < frames; ++k) folder.write("img_" + std::to_string(k) + ".pgm", pgm(k, 16, 8, 16));
        std::string table = "t_s,ax,ay,az\n";
        for (int i = 0; i < 100; ++i) table += to_text(0.001 * i) + ",1,2,9.8\n";
        folder.write("accel.csv", table);
    }
    [[nodiscard]] static std::string replaced(std::string text, const std::string& from,
                                              const std::string& to) {
        const auto at = text.find(from);
        EXPECT_NE(at, std::string::npos) << from;
        return at == std::string::npos ? text : text.replace(at, from.size(), to);
    }
    [[nodiscard]] LabSession read(const std::string& text) const {
        return read_lab_session(folder.write("session.toml", text));
    }
    [[nodiscard]] OpenLabSession open(const std::string& text) const {
        return open_lab_session(folder.write("session.toml", text));
    }
    /// Refusal after a replacement of `from` in a valid description.
    [[nodiscard]] std::string refused(const std::string& from, const std::string& to) const {
        return refusal([&] { (void)read(replaced(good, from, to)); });
    }
    /// Refusal when all frames are opened and read.
    [[nodiscard]] std::string refused_when_played(const std::string& text) const {
        return refusal([&] {
            const OpenLabSession session = open(text);
            for (const auto& camera : session.rig.cameras) all_frames(*camera);
        });
    }

    SessionFolder folder;
    const std::string good = R"(title = "a test"
[drive]
frequency_hz = 20.0
gamma_mps2 = 14.7
[accelerometer]
file = "accel.csv"
time = "t_s"
axes = ["ax", "ay", "az"]
clock_uncertainty_s = 0.05
shaker_axis = [0.6, 0.0, 0.8]
[[camera]]
name = "top"
file = "img_%d.pgm"
frame_rate_hz = 1000
first_exposure_s = 0.00015
exposure_s = 0.0003
mm_per_px = 0.25
distance_mm = 600.0
along = [1.0, 0.0]
[[camera.target]]
name = "walker"
kind = "disc"
diameter_mm = 30.0
roi_px = [1, 2, 10, 6]
offset_mm = 12.0
[[camera.target]]
name = "base"
kind = "dots"
diameter_mm = 2.6
pitch_mm = 8.0
roi_px = [0, 0, 16, 2]
polarity = "dark"
)";
};

TEST_F(LabSessionTest, ReadsEveryKeyOfValidDescription) {
    const LabSession session = read(good);
    EXPECT_EQ(session.title, "a test");
    ASSERT_TRUE(session.drive);
    EXPECT_EQ(session.drive->frequency_hz, 20);
    EXPECT_EQ(session.drive->gamma_mps2, 14.7);
    EXPECT_FALSE(session.drive->rho);
    EXPECT_FALSE(session.drive->phi_rad);
    ASSERT_TRUE(session.accelerometer);
    EXPECT_EQ(session.accelerometer->clock_uncertainty_s, 0.05);
    EXPECT_NEAR(session.accelerometer->shaker_axis[2], 0.8, 1e-15);
    ASSERT_EQ(session.cameras.size(), 1U);
    const View& view = session.cameras[0].view;
    EXPECT_EQ(view.camera, "top");
    EXPECT_EQ(view.mm_per_px, 0.25);
    EXPECT_EQ(view.distance_mm, 600);
    EXPECT_EQ(view.exposure_s, 0.0003);
    ASSERT_EQ(view.targets.size(), 2U);
    EXPECT_EQ(view.targets[0].kind, TargetKind::disc);
    EXPECT_EQ(view.targets[0].roi_px, (std::array<int, 4>{1, 2, 10, 6}));
    EXPECT_EQ(view.targets[0].offset_mm, 12);
    EXPECT_EQ(view.targets[0].polarity, Polarity::bright);
    EXPECT_EQ(view.targets[1].kind, TargetKind::dots);
    EXPECT_EQ(view.targets[1].pitch_mm, 8);
    EXPECT_EQ(view.targets[1].polarity, Polarity::dark);
    EXPECT_NO_THROW(require_reducible(session));
}

TEST_F(LabSessionTest, ASessionOpensAsARigWithoutADac) {
    const OpenLabSession session = open(good);
    EXPECT_EQ(session.rig.dac, nullptr);
    ASSERT_NE(session.rig.accelerometer, nullptr);
    EXPECT_NEAR(session.rig.accelerometer->info().rate_hz, 1000, 1e-6);
    ASSERT_EQ(session.rig.cameras.size(), 1U);
    Camera& camera = *session.rig.cameras[0];
    EXPECT_EQ(camera.view().frame_rate_hz, 1000);
    EXPECT_FALSE(camera.ended());
    const auto all = all_frames(camera);
    ASSERT_EQ(all.size(), 4U);
    EXPECT_TRUE(camera.ended());
    EXPECT_EQ(camera.read(no_wait), nullptr);
    for (int k = 0; k < frames; ++k) {
        const Frame& frame = *all[static_cast<std::size_t>(k)];
        EXPECT_EQ(frame.tick.n, k);
        EXPECT_EQ(frame.quality, Quality::good);
        EXPECT_EQ(frame.bytes_per_pixel, 2);
        ASSERT_TRUE(frame.mid_exposure);
        EXPECT_NEAR(seconds(*frame.mid_exposure), 0.00015 + 0.001 * k, 1e-15);
        expect_picture(frame, k, 16);
    }
}

TEST_F(LabSessionTest, TimesOverrideFrameRateAndShowMissing) {
    folder.write("times.csv", "t_s,note\n1.0,\n1.001,\n1.0041,late\n1.005,\n");
    const OpenLabSession session =
        open(replaced(good, "frame_rate_hz", "times = \"times.csv\"\nframe_rate_hz"));
    const auto all = all_frames(*session.rig.cameras[0]);
    ASSERT_EQ(all.size(), 4U);
    const std::array<double, 4> t{1.0, 1.001, 1.0041, 1.005};
    const std::array<std::int64_t, 4> ticks{0, 1, 4, 5};
    for (std::size_t k = 0; k < 4; ++k) {
        EXPECT_EQ(seconds(*all[k]->mid_exposure), t[k]);
        EXPECT_EQ(all[k]->tick.n, ticks[k]);
        EXPECT_EQ(all[k]->quality, k == 2 ? Quality::gap : Quality::good);
    }
}

TEST_F(LabSessionTest, TimesReplaceFrameRateAndFirstExposure) {
    std::filesystem::remove(folder / "img_2.pgm");
    folder.write("times.csv", "t_s\n0\n0.01\n0.03\n");
    const std::string text =
        replaced(good, "frame_rate_hz = 1000\nfirst_exposure_s = 0.00015", "times = \"times.csv\"");
    const OpenLabSession session = open(text);
    // The upper median of steps of 10 and 20 ms.
    EXPECT_NEAR(session.rig.cameras[0]->view().frame_rate_hz, 50, 1e-9);
    const auto all = all_frames(*session.rig.cameras[0]);
    ASSERT_EQ(all.size(), 3U);
    expect_picture(*all[2], 3, 16);
}

TEST_F(LabSessionTest, RefusesTimesOfWrongLengthWithBothCounts) {
    const std::string text = replaced(good, "frame_rate_hz", "times = \"times.csv\"\nframe_rate_hz");
    for (const int rows : {3, 5}) {
        std::string table = "t_s\n";
        for (int i = 0; i < rows; ++i) table += std::to_string(i) + "\n";
        folder.write("times.csv", table);
        expect_in(refused_when_played(text),
                  {"times.csv: has " + std::to_string(rows) + " rows", "has 4 frames"});
    }
    folder.write("times.csv", "t_s\n0\n2\n1\n3\n");
    expect_in(refused_when_played(text), {"times.csv:4: ", "1 follows 2"});
    folder.write("times.csv", "t\n0\n");
    expect_in(refused_when_played(text), {"times.csv:1: ", "\"t_s\" is missing"});
    std::filesystem::remove(folder / "times.csv");
    expect_in(refused_when_played(text), {"session.toml:14: camera.times: ", "times.csv", "No such file"});
}

TEST_F(LabSessionTest, UsesRateOfFileByDefault) {
    folder.write("run.mraw", std::string(96, 'x'));
    folder.write("run.cih",
                 "Record Rate(fps) : 2000\nTotal Frame : 3\nImage Width : 8\nImage Height : 4\n"
                 "Color Type : Mono\nColor Bit : 8\nFile Format : MRaw\nEND\n");
    const std::string text = replaced(replaced(good, "img_%d.pgm", "run.cih"), "frame_rate_hz = 1000\n", "");
    const auto session = open(text);
    EXPECT_EQ(session.rig.cameras[0]->view().frame_rate_hz, 2000);
    EXPECT_NEAR(seconds(*all_frames(*session.rig.cameras[0])[2]->mid_exposure), 0.00015 + 2 * 0.0005, 1e-15);
    expect_in(refused_when_played(replaced(text, "exposure_s = 0.0003", "exposure_s = 0.0006")),
              {"camera \"top\"", "exposure_s = 0.0006", "0.0005 s"});
}

TEST_F(LabSessionTest, ImagesWithoutARateOrTimesAreRefused) {
    expect_in(refused_when_played(replaced(good, "frame_rate_hz = 1000\n", "")),
              {"camera \"top\"", "img_%d.pgm", "frame_rate_hz or times"});
}

TEST_F(LabSessionTest, TrackingNeedsNeitherDriveNorAccelerometer) {
    const std::string text = good.substr(0, good.find("[drive]")) + good.substr(good.find("[[camera]]"));
    const OpenLabSession session = open(text);
    EXPECT_FALSE(session.description.drive);
    EXPECT_EQ(session.rig.accelerometer, nullptr);
    EXPECT_EQ(all_frames(*session.rig.cameras[0]).size(), 4U);
    expect_in(refusal([&] { require_reducible(session.description); }),
              {"session.toml", "[drive]", "frequency_hz"});
}

TEST_F(LabSessionTest, AReductionNeedsAnAccelerometerAWalkerAndABase) {
    const auto missing = [&](const std::string& text) {
        return refusal([&] { require_reducible(read(text)); });
    };
    const std::string no_accelerometer =
        good.substr(0, good.find("[accelerometer]")) + good.substr(good.find("[[camera]]"));
    expect_in(missing(no_accelerometer), {"session.toml", "[accelerometer]"});
    expect_in(missing(replaced(good, "\"walker\"", "\"disc\"")), {"session.toml", "\"walker\""});
    expect_in(missing(replaced(good, "\"base\"", "\"table\"")), {"session.toml", "\"base\""});
}

TEST_F(LabSessionTest, UnknownKeysAreRefusedInEveryTable) {
    expect_in(refused("title =", "titel ="), {"session.toml:1: titel: ", "did you mean \"title\"?"});
    expect_in(refused("gamma_mps2", "gamma"), {"session.toml:4: drive.gamma: ", "\"gamma_mps2\""});
    expect_in(refused("time =", "times ="), {"session.toml:", "accelerometer.time"});
    expect_in(refused("clock_uncertainty_s", "clock_error_s"),
              {"session.toml:9: accelerometer.clock_error_s: "});
    expect_in(refused("distance_mm", "distanse_mm"),
              {"session.toml:18: camera.distanse_mm: ", "\"distance_mm\""});
    expect_in(refused("offset_mm", "ofset_mm"),
              {"session.toml:25: camera.target.ofset_mm: ", "\"offset_mm\""});
}

TEST_F(LabSessionTest, NamesMissingFilesWithKeyAndLine) {
    expect_in(refused("accel.csv", "akcel.csv"),
              {"session.toml:6: accelerometer.file: ", "akcel.csv", "No such file"});
    expect_in(refused("img_%d.pgm", "top.mkv"),
              {"session.toml:13: camera.file: ", "top.mkv", "No such file"});
    expect_in(refused("img_%d.pgm", "sub/img_%d.pgm"), {"session.toml:13: camera.file: ", "sub/img_%d.pgm"});
    expect_in(refused("img_%d.pgm", ""), {"session.toml:13: camera.file: ", "a file name"});
    expect_in(refused_when_played(replaced(good, "img_%d.pgm", "pic_%d.pgm")),
              {"pic_%d.pgm", "no file matches"});
    expect_in(refusal([&] { read_lab_session(folder / "none.toml"); }), {"none.toml", "No such file"});
}

TEST_F(LabSessionTest, NamesErrorsInTableOfAccelerations) {
    expect_in(refused_when_played(replaced(good, "\"ay\"", "\"ayy\"")),
              {"accel.csv:1: ", "column \"ayy\" is missing", "\"ay\""});
    folder.write("accel.csv", "t_s,ax,ay,az\n0,1,2,3\n0.1,1,nan,3\n");
    expect_in(refused_when_played(good), {"accel.csv:3: ", "\"ay\"", "\"nan\""});
}

TEST_F(LabSessionTest, RegionsMustBeFourWholeNumbersInReach) {
    for (const std::string roi :
         {"[1, 2, 10]", "[1, 2, 10, 6, 7]", "[1, 2, 10.5, 6]", "[1, 2, -10, 6]", "[1, 2, 0, 6]",
          "[-1, 2, 10, 6]", "[1, 2, 10, 1e9]", "\"1, 2, 10, 6\"", "[1, 2, 10, \"6\"]"})
        expect_in(refused("[1, 2, 10, 6]", roi), {"session.toml:24: camera.target.roi_px: "});
}

TEST_F(LabSessionTest, DirectionVectorsMustHaveUnitLength) {
    expect_in(refused("[1.0, 0.0]", "[1.0, 0.1]"), {"session.toml:19: camera.along: ", "length 1.0049875"});
    expect_in(refused("[1.0, 0.0]", "[0, 0]"), {"camera.along: ", "length 0"});
    expect_in(refused("[1.0, 0.0]", "[1, 0, 0]"), {"camera.along: ", "an array of 2 numbers"});
    expect_in(refused("[0.6, 0.0, 0.8]", "[0, 0, 0]"),
              {"session.toml:10: accelerometer.shaker_axis: ", "length 0"});
    expect_in(refused("[0.6, 0.0, 0.8]", "\"fitt\""), {"accelerometer.shaker_axis: ", "\"fit\""});
    const auto session = read(replaced(good, "[1.0, 0.0]", "[0.7071, 0.7071]"));
    EXPECT_NEAR(session.cameras[0].view.along[0], std::sqrt(0.5), 1e-15);
    EXPECT_EQ(read(replaced(good, "[0.6, 0.0, 0.8]", "\"fit\"")).accelerometer->shaker_axis,
              (std::array<double, 3>{}));
}

TEST_F(LabSessionTest, OneColumnOfAccelerationsIsEnough) {
    const std::string three = R"(axes = ["ax", "ay", "az"])";
    const auto one = read(replaced(replaced(good, three, R"(axes = ["ax"])"), "[0.6, 0.0, 0.8]", "\"fit\""));
    EXPECT_EQ(one.accelerometer->axes.size(), 1U);
    EXPECT_FALSE(one.accelerometer->gravity);
    EXPECT_EQ(one.accelerometer->shaker_axis, (std::array<double, 3>{1, 0, 0}));
    const auto two = read(replaced(replaced(good, three, "axes = [\"ax\", \"ay\"]\ngravity = true"),
                                   "[0.6, 0.0, 0.8]", "[0.6, 0.8, 0.0]"));
    EXPECT_TRUE(two.accelerometer->gravity);
    EXPECT_TRUE(read(good).accelerometer->gravity);
    expect_in(refused(three, R"(axes = ["ax"])"), {"shaker_axis", "part along z", "it has 1 axis"});
    expect_in(refused(three, "axes = []"), {"an array of 1 to 3 texts"});
}

TEST_F(LabSessionTest, ValuesOutOfRangeAreRefusedByKeyAndLine) {
    const auto expect_refused = [&](const std::string& from, const std::string& to,
                                    const std::string& where) {
        expect_in(refused(from, to), {"session.toml:" + where + ": "});
    };
    expect_refused("frequency_hz = 20.0", "frequency_hz = 0.09", "3: drive.frequency_hz");
    expect_refused("frequency_hz = 20.0", "frequency_hz = 5001", "3: drive.frequency_hz");
    expect_refused("frequency_hz = 20.0", "frequency_hz = \"20\"", "3: drive.frequency_hz");
    expect_refused("frequency_hz = 20.0", "rho = 0.5", "2: drive.frequency_hz");
    expect_refused("gamma_mps2 = 14.7", "rho = 1.5", "4: drive.rho");
    expect_refused("clock_uncertainty_s = 0.05", "clock_uncertainty_s = -1",
                   "9: accelerometer.clock_uncertainty_s");
    expect_refused("frame_rate_hz = 1000", "frame_rate_hz = 0", "14: camera.frame_rate_hz");
    expect_refused("first_exposure_s = 0.00015", "first_exposure_s = nan", "15: camera.first_exposure_s");
    expect_refused("first_exposure_s = 0.00015\n", "", "11: camera.first_exposure_s");
    expect_refused("exposure_s = 0.0003", "exposure_s = 0.0011", "16: camera.exposure_s");
    expect_refused("mm_per_px = 0.25", "mm_per_px = 0", "17: camera.mm_per_px");
    expect_refused("mm_per_px = 0.25", "mm_per_px = -0.25", "17: camera.mm_per_px");
    expect_refused("distance_mm = 600.0", "distance_mm = 12", "25: camera.target.offset_mm");
    expect_refused("kind = \"disc\"", "kind = \"ball\"", "22: camera.target.kind");
    expect_refused("polarity = \"dark\"", "polarity = \"black\"", "32: camera.target.polarity");
    expect_refused("pitch_mm = 8.0", "pitch_mm = 2.0", "30: camera.target.pitch_mm");
}

TEST_F(LabSessionTest, EveryKindOfTargetNeedsItsLength) {
    for (const auto& [kind, key] : {std::pair{"disc", "diameter_mm"},
                                    {"rectangle", "width_mm"},
                                    {"dots", "diameter_mm"},
                                    {"bars", "pitch_mm"}})
        expect_in(refused("kind = \"disc\"\ndiameter_mm = 30.0", "kind = \"" + std::string{kind} + "\""),
                  {"session.toml:20: camera.target." + std::string{key} + ": ", "missing"});
    const auto session = read(replaced(good, "kind = \"disc\"\ndiameter_mm = 30.0", "kind = \"patch\""));
    EXPECT_EQ(session.cameras[0].view.targets[0].kind, TargetKind::patch);
}

TEST_F(LabSessionTest, NamesMustBeUniqueAndFitIntoTables) {
    expect_in(refused("\"base\"", "\"walker\""),
              {"session.toml:27: camera.target.name: ", "\"walker\" is used twice"});
    const std::string camera = good.substr(good.find("[[camera]]"));
    expect_in(refusal([&] { (void)read(good + camera); }),
              {"session.toml:34: camera.name: ", "\"top\" is used twice"});
    EXPECT_EQ(read(good + replaced(camera, "\"top\"", "\"side\"")).cameras.size(), 2U);
    for (const std::string name : {"", "a,b", "a/b", "a\\nb"})
        expect_in(refused("\"base\"", "\"" + name + "\""), {"session.toml:27: camera.target.name: "});
}

TEST_F(LabSessionTest, ThereMustBeACameraWithATarget) {
    expect_in(refusal([&] { (void)read("title = \"empty\"\n"); }),
              {"session.toml:1: camera: ", "[[camera]]"});
    expect_in(refusal([&] { (void)read(good.substr(0, good.find("[[camera.target]]"))); }),
              {"session.toml:11: camera.target: ", "\"top\" has no target"});
    expect_in(refusal([&] { (void)read("camera = 3\n"); }),
              {"session.toml:1: camera: expected tables [[camera]], got 3"});
}

}  // namespace
}  // namespace shaker::footage

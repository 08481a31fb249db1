// Files as cameras, loggers and other programs write them: the cases of public bug reports, made for this
// test. Each has its right value, or the sentence of its refusal.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <fstream>

#include "drivers/footage/lab_session.hpp"
#include "drivers/time.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/recording/recording_folder.hpp"

namespace shaker::footage {
namespace {

using test::expect_in;
using test::no_wait;
using test::refusal;
using test::SessionFolder;

const std::filesystem::path cases = test::source_dir() + "/tests/drivers/footage/cases";

const std::string target =
    "[[camera.target]]\nname = \"walker\"\nkind = \"disc\"\ndiameter_mm = 8\nroi_px = [2, 2, 12, 12]\n";

struct Footage {
    std::vector<double> t_s;
    std::vector<std::int64_t> ticks;
    std::vector<FramePtr> frames;
    std::string notes;
};

/// All pictures of a camera. more: further keys.
Footage read_all(const SessionFolder& folder, const std::filesystem::path& media,
                 const std::string& more = {}) {
    const auto file =
        folder.write("session.toml", "[[camera]]\nname = \"top\"\nfile = \"" + media.string() +
                                         "\"\nfirst_exposure_s = 0.0\nmm_per_px = 1.0\n" + more + target);
    OpenLabSession session = open_lab_session(file);
    Footage all;
    for (const std::string& note : session.notes) all.notes += note + "\n";
    Camera& camera = *session.rig.cameras.front();
    while (!camera.ended())
        if (FramePtr frame = camera.read(no_wait)) {
            all.t_s.push_back(seconds(frame->mid_exposure.value()));
            all.ticks.push_back(frame->tick.n);
            all.frames.push_back(std::move(frame));
        }
    return all;
}

std::vector<double> times_in(const std::filesystem::path& file) {
    std::ifstream in{file};
    std::vector<double> times;
    for (double t = 0; in >> t;) times.push_back(t);
    return times;
}

TEST(PublicCasesTest, AMoviesOwnTimesAreUsed) {
    const SessionFolder folder;
    for (const std::string name : {"dropped", "slower", "jitter"}) {
        const Footage got = read_all(folder, cases / (name + ".mp4"));
        const std::vector<double> right = times_in(cases / (name + ".times"));
        ASSERT_EQ(got.t_s.size(), right.size()) << name;
        for (std::size_t i = 0; i < right.size(); ++i) EXPECT_NEAR(got.t_s[i], right[i], 1e-4) << name << i;
        expect_in(got.notes, {name == "dropped" ? "12 are lost, at most 1 in a row" : "not evenly spaced"});
        EXPECT_EQ(got.ticks.back() + 1 > std::ssize(right), name == "dropped") << name;
    }
}

TEST(PublicCasesTest, AStatedRateThatDisagreesIsTold) {
    const SessionFolder folder;
    const Footage slow = read_all(folder, cases / "dropped.mp4", "frame_rate_hz = 1200\n");
    expect_in(slow.notes, {"frame_rate_hz = 1200 is used", "60 pictures/s"});
    EXPECT_NEAR(slow.t_s.back(), times_in(cases / "dropped.times").back() / 20, 1e-6);
    EXPECT_EQ(read_all(folder, cases / "dropped.mp4", "frame_rate_hz = 60\n").notes.find("is used"),
              std::string::npos);
    expect_in(refusal([&] { read_all(folder, cases / "jitter.mp4", "frame_rate_hz = 1200\n"); }),
              {"uneven", "frame_rate_hz = 1200", "leave frame_rate_hz out"});
}

// Matroska counts milliseconds: two pictures of 2000/s have the same stamp.
TEST(PublicCasesTest, StampsThatAreTooCoarseLeaveTheRate) {
    const SessionFolder folder;
    const Footage got = read_all(folder, cases / "fast.mkv", "frame_rate_hz = 2000\n");
    EXPECT_EQ(got.ticks.back() + 1, 40);
    EXPECT_NEAR(got.t_s.back(), 39.0 / 2000, 1e-9);
    expect_in(refusal([&] { read_all(folder, cases / "fast.mkv"); }), {"too coarse", "set frame_rate_hz"});
}

TEST(PublicCasesTest, OnlyATrueCountCutsAMovieShort) {
    const SessionFolder folder;
    const Footage longer = read_all(folder, cases / "longer_sound.mkv");
    EXPECT_EQ(longer.t_s.size(), times_in(cases / "dropped.times").size());
    expect_in(longer.notes, {"pictures end at 1.98", "header states 9"});
    EXPECT_EQ(read_all(folder, cases / "edit_list.mp4").t_s.size(), 87U);
    expect_in(refusal([&] { read_all(folder, cases / "cut_short.mkv"); }), {"cut_short.mkv: is cut short"});
    const auto whole = std::filesystem::file_size(cases / "slower.mp4");
    std::filesystem::copy_file(cases / "slower.mp4", folder / "half.mp4");
    std::filesystem::resize_file(folder / "half.mp4", whole - 3000);
    EXPECT_NE(refusal([&] { read_all(folder, folder / "half.mp4"); }), "accepted");
}

TEST(PublicCasesTest, ABareStreamHasNoRate) {
    const SessionFolder folder;
    expect_in(refusal([&] { read_all(folder, cases / "bare.h264"); }),
              {"does not state its frame rate", "frame_rate_hz or times"});
    EXPECT_NEAR(read_all(folder, cases / "bare.h264", "frame_rate_hz = 120\n").t_s.back(), 61 / 120.0, 1e-6);
}

TEST(PublicCasesTest, InterlacedPicturesAreTold) {
    const SessionFolder folder;
    expect_in(read_all(folder, cases / "interlaced.mpg").notes, {"is interlaced"});
}

TEST(PublicCasesTest, HighSpeedFilesHaveTheirOwnTimes) {
    const SessionFolder folder;
    const Footage step = read_all(folder, cases / "bench.cih"), cine = read_all(folder, cases / "bench.cine"),
                  gap = read_all(folder, cases / "gap.cine");
    expect_in(step.notes, {"Save Step : 10", "60 pictures/s"});
    EXPECT_NEAR(step.t_s.back(), 11 / 60.0, 1e-6);
    EXPECT_NEAR(cine.t_s.back(), 11 / 60.0, 1e-6);
    EXPECT_NEAR(gap.t_s.back(), 23 / 60.0, 1e-6);
    EXPECT_EQ(gap.ticks.at(6) - gap.ticks.at(5), 13);
    std::filesystem::copy(cases / "bench.mraw", folder / "odd.mraw");
    std::ifstream header{cases / "bench.cih"};
    std::string text{std::istreambuf_iterator<char>{header}, {}};
    folder.write("odd.cih", text.insert(text.find("Save Step"), "Frame Skip : 4\r\n"));
    expect_in(read_all(folder, folder / "odd.cih").notes, {"\"Frame Skip : 4\" may change the rate"});
}

TEST(PublicCasesTest, AllPagesOfATiffAreReadWithAllBits) {
    const SessionFolder folder;
    std::filesystem::create_directories(folder / "stack");
    std::filesystem::copy(cases / "run.tif", folder / "stack" / "run.tif");
    for (const char* name : {"stack", "stack/run.tif"}) {
        const Footage got = read_all(folder, folder / name, "frame_rate_hz = 100\n");
        ASSERT_EQ(got.frames.size(), 5U) << name;
        EXPECT_EQ(got.frames.front()->bytes_per_pixel, 2) << name;
        EXPECT_NE(got.frames.front()->pixels, got.frames.back()->pixels) << name;
    }
}

// macOS keeps the properties of a file in another one beside it.
TEST(PublicCasesTest, HiddenFilesAreNoPictures) {
    const SessionFolder folder;
    std::filesystem::create_directories(folder / "pictures");
    std::filesystem::copy(cases / "run.tif", folder / "pictures" / "f0.tif");
    std::ofstream{folder / "pictures" / "._f0.tif"} << "Mac OS X        ";
    EXPECT_EQ(read_all(folder, folder / "pictures", "frame_rate_hz = 100\n").frames.size(), 5U);
}

TEST(PublicCasesTest, OtherContainersAreNamed) {
    const SessionFolder folder;
    expect_in(refusal([&] { read_all(folder, folder.write("run.seq", "Norpix seq")); }),
              {"run.seq", "StreamPix (NorPix)", "save them as"});
}

struct Table {
    const char* file;
    std::string keys;
};

const std::string phone =
    "time = \"Time (s)\"\naxes = [\"Acceleration x (m/s^2)\", \"Acceleration y (m/s^2)\", "
    "\"Acceleration z (m/s^2)\"]\n";

TEST(PublicCasesTest, TablesOfLoggersAreRead) {
    const SessionFolder folder;
    const std::array tables{
        Table{"semicolon_comma.csv", phone},
        Table{"tab.csv", phone},
        Table{"quoted_all.csv", phone},
        Table{"metadata_lines.csv", phone},
        Table{"utf16.csv", phone},
        Table{"cr_only.csv", phone},
        Table{"comma_in_heading.csv", "time = \"Time, s\"\naxes = [\"Acc, x\", \"Acc, y\", \"Acc, z\"]\n"}};
    for (const Table& table : tables) {
        const auto file =
            folder.write("session.toml", "[accelerometer]\nfile = \"" + (cases / table.file).string() +
                                             "\"\n" + table.keys + "[[camera]]\nname = \"top\"\nfile = \"" +
                                             (cases / "bench.cih").string() +
                                             "\"\nfirst_exposure_s = 0\nmm_per_px = 1.0\n" + target);
        const OpenLabSession session = open_lab_session(file);
        AccelBlock block;
        ASSERT_TRUE(session.rig.accelerometer->read(block, no_wait)) << table.file;
        const AccelerometerInfo info = session.rig.accelerometer->info();
        EXPECT_NEAR(info.rate_hz, 1000, 1e-3) << table.file;
        EXPECT_NEAR(info.acceleration(block.counts[1])[0], 0.250666, 1e-6) << table.file;
        EXPECT_NEAR(info.acceleration(block.counts[1])[2], 9.81, 1e-6) << table.file;
    }
}

}  // namespace
}  // namespace shaker::footage

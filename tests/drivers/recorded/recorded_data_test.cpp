#include "drivers/footage/lab_session.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/recording/recording_folder.hpp"

namespace shaker::recorded {
namespace {

using namespace test;

/// The sessions in tests/sessions, on recordings of real cameras.
class RecordedDataTest : public ::testing::Test {
protected:
    void SetUp() override {
        if (!recorded_data().empty()) return;
        if (std::getenv("CI") != nullptr) FAIL() << "the folder of recorded data is not beside the sources";
        GTEST_SKIP() << "needs the data sets of tests/drivers/footage/sessions in ../shared/data, which a "
                        "clone does not "
                        "have";
    }
    [[nodiscard]] static footage::OpenLabSession open(const std::string& name) {
        return footage::open_lab_session(std::filesystem::path{test::source_dir()} /
                                         "tests/drivers/footage/sessions" / (name + ".toml"));
    }
    static void expect_stream(Camera& camera, int width, int height, std::size_t count, double rate_hz) {
        EXPECT_EQ(camera.view().frame_rate_hz, rate_hz);
        std::size_t frames = 0;
        while (!camera.ended()) {
            const FramePtr frame = camera.read(no_wait);
            ASSERT_NE(frame, nullptr);
            EXPECT_EQ(frame->width, width);
            EXPECT_EQ(frame->height, height);
            EXPECT_EQ(frame->quality, Quality::good);
            EXPECT_EQ(frame->tick.n, static_cast<std::int64_t>(frames));
            ++frames;
        }
        EXPECT_EQ(frames, count);
    }
    /// Every region lies in the picture.
    static void expect_regions_inside(const View& view, int width, int height) {
        for (const Target& target : view.targets) {
            EXPECT_LE(target.roi_px[0] + target.roi_px[2], width) << view.camera << " " << target.name;
            EXPECT_LE(target.roi_px[1] + target.roi_px[3], height) << view.camera << " " << target.name;
        }
    }
};

TEST_F(RecordedDataTest, TheLabSessionOpensAndIsReducible) {
    const auto session = open("lab-session");
    EXPECT_NO_THROW(require_reducible(session.description));
    // The container plays slower than frame_rate_hz = 1000.
    ASSERT_EQ(session.notes.size(), 2U);
    for (const std::string& note : session.notes) expect_in(note, {"frame_rate_hz = 1000", "25 pictures/s"});
    ASSERT_EQ(session.rig.cameras.size(), 2U);
    expect_regions_inside(session.rig.cameras[0]->view(), 512, 144);
    expect_regions_inside(session.rig.cameras[1]->view(), 512, 96);
    expect_stream(*session.rig.cameras[0], 512, 144, 300, 1000);
    expect_stream(*session.rig.cameras[1], 512, 96, 300, 1000);
    EXPECT_NEAR(session.rig.accelerometer->info().rate_hz, 4000, 1e-6);
    int samples = 0;
    for (AccelBlock block; session.rig.accelerometer->read(block, no_wait); samples += block.size)
        EXPECT_EQ(block.quality, Quality::good);
    EXPECT_EQ(samples, 1200);
}

TEST_F(RecordedDataTest, TheModelBuildingHasSevenDotsOnEachBeam) {
    const auto session = open("building-swing");
    ASSERT_EQ(session.rig.cameras.size(), 2U);
    for (const auto& camera : session.rig.cameras) EXPECT_EQ(camera->view().targets.size(), 7U);
    expect_regions_inside(session.rig.cameras[0]->view(), 1300, 100);
    expect_regions_inside(session.rig.cameras[1]->view(), 1300, 90);
    expect_stream(*session.rig.cameras[0], 1300, 100, 160, 20);
    expect_stream(*session.rig.cameras[1], 1300, 90, 160, 20);
}

TEST_F(RecordedDataTest, PhotronRecordingHasSizeAndRate) {
    const auto session = open("photron");
    expect_regions_inside(session.rig.cameras[0]->view(), 640, 40);
    // "Record Rate(fps) : 15000" and "Save Step : 100": one of 100 exposures was saved.
    ASSERT_EQ(session.notes.size(), 1U);
    expect_in(session.notes.front(), {"Save Step : 100", "150 pictures/s"});
    expect_stream(*session.rig.cameras[0], 640, 40, 75, 150);
}

TEST_F(RecordedDataTest, ThePhantomRecordingKeepsMoreThanEightBits) {
    const auto session = open("phantom");
    expect_regions_inside(session.rig.cameras[0]->view(), 256, 32);
    const FramePtr first = session.rig.cameras[0]->read(no_wait);
    EXPECT_EQ(first->bytes_per_pixel, 2);
    EXPECT_GT(largest(*first), 255U);
    // The camera has written a wrong time for its last picture.
    ASSERT_EQ(open("phantom").notes.size(), 1U);
    expect_in(open("phantom").notes.front(), {"the stamp of its last picture", "is not believed"});
    expect_stream(*open("phantom").rig.cameras[0], 256, 32, 235, 100);
}

/// The screw's dark hole is in the upper half when the right row comes first: the file stores the bottom row
/// first.
TEST_F(RecordedDataTest, ThePhantomRecordingIsTheRightWayUp) {
    const FramePtr frame = open("phantom").rig.cameras[0]->read(no_wait);
    const auto mean = [&](int from_y, int to_y) {
        double sum = 0;
        for (int y = from_y; y < to_y; ++y)
            for (int x = 140; x < 162; ++x) sum += pixel(*frame, x, y);
        return sum / (22.0 * (to_y - from_y));
    };
    EXPECT_LT(mean(4, 24), 0.8 * mean(28, 32));
}

/// A movie cut in the middle still decodes up to there: it must not pass for a short recording.
TEST_F(RecordedDataTest, RefusesTruncatedMovie) {
    const SessionFolder folder;
    std::ifstream whole{recorded_data() / "lab-session/side.mkv", std::ios::binary};
    std::string bytes(3000000, '\0');
    whole.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    folder.write("side.mkv", bytes);
    const auto file = folder.write("session.toml",
                                   "[[camera]]\nname = \"side\"\nfile = \"side.mkv\"\nframe_rate_hz = 1000\n"
                                   "first_exposure_s = 0\nmm_per_px = 1\n[[camera.target]]\nname = \"base\"\n"
                                   "kind = \"patch\"\nroi_px = [0, 0, 9, 9]\n");
    expect_in(refusal([&] { all_frames(*footage::open_lab_session(file).rig.cameras[0]); }),
              {"side.mkv: is cut short", "12.0", "s"});
}

}  // namespace
}  // namespace shaker::recorded

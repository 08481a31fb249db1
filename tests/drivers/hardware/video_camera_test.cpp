#include "drivers/hardware/video/video_camera.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/videoio.hpp>
#include <thread>

#include "drivers/errors.hpp"
#include "drivers/hardware/video/kind.hpp"
#include "tests/support/program.hpp"
#include "tests/support/tracking/grey_movie.hpp"

namespace shaker::hardware {
namespace {

using namespace std::chrono_literals;

constexpr int width = 48, height = 32, frames = 20, many_frames = 300;
constexpr double rate_hz = 50;

class VideoCameraTest : public ::testing::Test {
protected:
    void SetUp() override {
        settings_.file = test::fresh_folder() / "movie.avi";
        view_.camera = "top";
        write_movie(frames);
    }
    void write_movie(int count) const {
        cv::VideoWriter writer{settings_.file.string(), cv::CAP_FFMPEG,
                               cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), rate_hz, cv::Size{width, height}};
        cv::Mat picture(height, width, CV_8UC3);
        for (int i = 0; i < count; ++i) {
            for (int y = 0; y < height; ++y)
                for (int x = 0; x < width; ++x)
                    picture.at<cv::Vec3b>(y, x) = {static_cast<uchar>(5 * x + 10 * i),
                                                   static_cast<uchar>(7 * y), static_cast<uchar>(3 * i)};
            writer.write(picture);
        }
    }
    std::string refusal() {
        try {
            open_video_camera(settings_, view_);
        } catch (const DeviceError& error) {
            return error.what();
        }
        return "opened";
    }
    video::VideoSettings settings_;
    View view_;
};

TEST_F(VideoCameraTest, FastMovieReturnsEveryPicture) {
    settings_.paced = false;
    const auto shots = test::grey_movie(settings_.file);
    const auto camera = open_video_camera(settings_, view_);
    EXPECT_EQ(camera->view().frame_rate_hz, rate_hz);
    for (int i = 0; i < frames; ++i) {
        ASSERT_FALSE(camera->ended());
        const FramePtr frame = camera->read(0ms);
        ASSERT_NE(frame, nullptr);
        EXPECT_EQ(frame->tick.n, i);
        EXPECT_EQ(frame->stamp->n, 20'000'000 * i);
        EXPECT_EQ(frame->quality, Quality::good);
        const auto& shot = shots[static_cast<std::size_t>(i)];
        ASSERT_EQ(frame->pixels.size(), shot.pixels.size());
        EXPECT_EQ(std::memcmp(frame->pixels.data(), shot.pixels.data(), shot.pixels.size()), 0) << i;
    }
    EXPECT_TRUE(camera->ended());
    EXPECT_EQ(camera->read(0ms), nullptr);
    EXPECT_EQ(camera->counts().taken, static_cast<std::uint64_t>(frames));
}

TEST_F(VideoCameraTest, AMovieAtItsRateIsNeverEarly) {
    const auto camera = open_video_camera(settings_, view_);
    const HostTime began{std::chrono::steady_clock::now().time_since_epoch()};  // the same clock
    int came = 0;
    while (!camera->ended()) {
        const FramePtr frame = camera->read(200ms);
        if (frame == nullptr) continue;
        EXPECT_GE(frame->arrived - began, 20ms * frame->tick.n);
        ++came;
    }
    EXPECT_EQ(came, frames);
}

TEST_F(VideoCameraTest, ReadReturnsAfterItsWait) {
    settings_.frame_rate_hz = 0.01;
    const auto camera = open_video_camera(settings_, view_);
    EXPECT_EQ(camera->view().frame_rate_hz, 0.01);
    EXPECT_NE(camera->read(0ms), nullptr);
    EXPECT_EQ(camera->read(10ms), nullptr);  // the next one is due in 100 s
    std::jthread stopper{[&] {
        std::this_thread::sleep_for(20ms);
        camera->stop();
    }};
    EXPECT_EQ(camera->read(std::chrono::hours{1}), nullptr);
    EXPECT_TRUE(camera->ended());
}

TEST_F(VideoCameraTest, FastMovieWaitsForFreeFrame) {
    write_movie(many_frames);
    settings_.paced = false;
    std::vector<FramePtr> held;
    const auto camera = open_video_camera(settings_, view_);
    while (FramePtr frame = camera->read(0ms)) held.push_back(std::move(frame));
    EXPECT_EQ(held.size(), 256u);  // as many as the pool has
    EXPECT_FALSE(camera->ended());
    held.clear();
    while (FramePtr frame = camera->read(0ms)) held.push_back(std::move(frame));
    EXPECT_TRUE(camera->ended());
    EXPECT_EQ(held.back()->tick.n, many_frames - 1);
    EXPECT_EQ(camera->counts().taken, static_cast<std::uint64_t>(many_frames));
    EXPECT_EQ(camera->counts().lost, 0u);
}

TEST_F(VideoCameraTest, NamesFileThatCannotBeOpened) {
    settings_.file = "/nonexistent/movie.avi";
    EXPECT_EQ(refusal(),
              "camera \"top\" (/nonexistent/movie.avi): cannot be opened: No such file or directory");
    settings_ = {};
    settings_.device = "/dev/video77";
    EXPECT_EQ(refusal(), "camera \"top\" (/dev/video77): cannot be opened: No such file or directory");
    settings_ = {};
    settings_.file = test::fresh_folder() / "text.avi";
    std::ofstream{settings_.file} << "no movie";
    EXPECT_NE(refusal().find("OpenCV cannot read its format"), std::string::npos) << refusal();
}

TEST_F(VideoCameraTest, SettingsNameEitherADeviceOrAFile) {
    const auto read = [](const std::string& text) {
        SettingsTable table = SettingsTable::from_text(text, "/rig/bench.toml");
        video::VideoSettings s = video::read_video_settings(table);
        table.finish();
        return s;
    };
    const video::VideoSettings s = read("file = 'x.avi'\npace = 'fast'\nframe_rate_hz = 200\n");
    EXPECT_EQ(s.file, "/rig/x.avi");
    EXPECT_FALSE(s.paced);
    EXPECT_EQ(s.frame_rate_hz, 200);
    EXPECT_EQ(read("device = '/dev/video0'\nwidth_px = 320\nheight_px = 180\n").width, 320);
    EXPECT_THROW(read("frame_rate_hz = 200\n"), InputError);
    EXPECT_THROW(read("file = 'x.avi'\ndevice = '/dev/video0'\n"), InputError);
    EXPECT_THROW(read("device = '/dev/video0'\nwidth_px = 320\n"), InputError);
}

TEST(VideoDevicesTest, ListsUnreadableDeviceWithReason) {
    const auto folder = test::fresh_folder();
    std::ofstream{folder / "video0"} << "not a device";
    std::ofstream{folder / "audio0"} << "something else";
    const auto devices = video::list_video_devices(folder);
    ASSERT_EQ(devices.size(), 1u);
    const auto device = nlohmann::json::parse(devices[0].json);
    EXPECT_EQ(device.at("path"), (folder / "video0").string());
    EXPECT_EQ(device.at("error"), "Inappropriate ioctl for device");
    EXPECT_TRUE(devices[0].text.ends_with("\n      Inappropriate ioctl for device\n")) << devices[0].text;
    EXPECT_TRUE(video::list_video_devices(folder / "nothing").empty());
}

}  // namespace
}  // namespace shaker::hardware

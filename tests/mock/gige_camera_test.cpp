#include "tests/mock/gige_camera.hpp"

#include <gtest/gtest.h>

#include "drivers/errors.hpp"
#include "drivers/hardware/genicam/genicam_camera.hpp"
#include "tests/support/devices/mock_cameras.hpp"

namespace shaker::mock {
namespace {

using test::next_frame, test::numbered_picture, test::same_picture;

constexpr std::int64_t period_ns = 5'000'000;

/// A mock camera and a client of the real GigE Vision stack.
class GigeCameraTest : public ::testing::Test {
protected:
    void SetUp() override {
        const std::string refused = test::private_network();
        if (!refused.empty()) GTEST_SKIP() << refused;
    }
    static genicam::GenicamSettings client_settings() {
        genicam::GenicamSettings s;
        s.id = "127.0.0.1";
        s.frame_rate_hz = 200;
        return s;
    }
    static View top_view() {
        View view;
        view.camera = "top";
        return view;
    }
    void push(GigeCamera& camera, int n) {
        for (int i = 0; i < n; ++i, ++pushed_)
            camera.push(numbered_picture(pushed_, 512, 96), static_cast<std::int64_t>(pushed_) * period_ns);
    }
    /// Checks that the picture has the pixels and the tick that belong to its stamp. Returns its number.
    static std::uint64_t verified(const Frame& frame) {
        const auto number = static_cast<std::uint64_t>(frame.stamp->n / period_ns);
        EXPECT_TRUE(same_picture(frame, *numbered_picture(number, 512, 96))) << number;
        EXPECT_EQ(frame.tick.n, static_cast<std::int64_t>(number));
        return number;
    }
    /// Number of received pictures; the last received one must be the last pushed one.
    [[nodiscard]] std::uint64_t received_all(Camera& client) const {
        std::uint64_t n = 0;
        while (const FramePtr frame = next_frame(client)) {
            ++n;
            if (verified(*frame) + 1 == pushed_) return n;
        }
        ADD_FAILURE() << "picture " << pushed_ - 1 << " did not come";
        return n;
    }
    /// Pushes pictures one by one and takes each completely transmitted one; returns their number.
    std::uint64_t exchange(GigeCamera& camera, Camera& client, int n) {
        std::uint64_t came = 0;
        for (int i = 0; i < n; ++i) {
            const std::uint64_t before = camera.counts().transmitted;
            push(camera, 1);
            EXPECT_TRUE(camera.drained(5));
            if (camera.counts().transmitted == before) continue;
            const FramePtr frame = next_frame(client);
            EXPECT_TRUE(frame != nullptr && verified(*frame) + 1 == pushed_);
            ++came;
        }
        return came;
    }
    std::uint64_t pushed_ = 0;
};

TEST_F(GigeCameraTest, PicturesAndStampsArriveAsTheyWerePushed) {
    GigeCamera camera{{.first_id = 65500}};  // ids wrap on the way
    const auto client = open_genicam_camera(client_settings(), top_view());
    EXPECT_EQ(exchange(camera, *client, 40), 40u);
    EXPECT_EQ(camera.counts().transmitted, 40u);
    EXPECT_EQ(client->counts().taken, 40u);
    EXPECT_EQ(client->counts().lost, 0u);
    EXPECT_EQ(client->counts().incidents, 0u);
}

TEST_F(GigeCameraTest, TheClientsSettingsCanBeRead) {
    GigeCamera camera{{}};
    EXPECT_FALSE(camera.requested().acquiring);
    genicam::GenicamSettings s = client_settings();
    s.region_px = {16, 8, 256, 64};
    s.exposure_s = 0.0005;
    s.gain = 6.5;
    s.trigger_source = "Line1";
    auto client = open_genicam_camera(s, top_view());
    GigeRequest r = camera.requested();
    EXPECT_TRUE(r.acquiring);
    EXPECT_TRUE(r.triggered);
    EXPECT_EQ(r.source, "Line1");
    EXPECT_EQ(r.region_px, s.region_px);
    EXPECT_DOUBLE_EQ(r.exposure_s, 0.0005);
    EXPECT_DOUBLE_EQ(r.gain_dB, 6.5);
    client.reset();
    EXPECT_FALSE(camera.requested().acquiring);

    s.trigger = genicam::CameraTrigger::free;
    client = open_genicam_camera(s, top_view());
    r = camera.requested();
    EXPECT_FALSE(r.triggered);
    EXPECT_DOUBLE_EQ(r.frame_rate_hz, 200);
}

TEST_F(GigeCameraTest, CutsPictureToRequestedRegion) {
    GigeCamera camera{{}};
    genicam::GenicamSettings s = client_settings();
    s.region_px = {16, 8, 256, 64};
    const auto client = open_genicam_camera(s, top_view());
    const FramePtr whole = numbered_picture(3, 512, 96);
    camera.push(whole, 1);
    const FramePtr frame = next_frame(*client);
    ASSERT_NE(frame, nullptr);
    ASSERT_EQ(frame->width, 256);
    ASSERT_EQ(frame->height, 64);
    for (int y = 0; y < 64; ++y)
        for (int x = 0; x < 256; ++x) ASSERT_EQ(frame->view().row(y)[x], whole->view().row(y + 8)[x + 16]);
}

TEST_F(GigeCameraTest, DroppedExposuresAreLostAtTheClient) {
    GigeCamera camera{{}};
    const auto client = open_genicam_camera(client_settings(), top_view());
    EXPECT_EQ(exchange(camera, *client, 10), 10u);
    camera.drop(7);
    EXPECT_EQ(exchange(camera, *client, 20), 13u);
    EXPECT_EQ(camera.counts().dropped, 7u);
    EXPECT_EQ(client->counts().lost, 7u);
    EXPECT_EQ(client->counts().taken, 23u);
}

TEST_F(GigeCameraTest, LosesOnlyPicturesWithLostPackets) {
    GigeCamera camera{{}};
    const auto client = open_genicam_camera(client_settings(), top_view());
    push(camera, 1);
    EXPECT_EQ(received_all(*client), 1u);
    camera.lose(0.01);  // 38 packets a picture: about a third of the pictures
    std::uint64_t came = exchange(camera, *client, 100);
    camera.lose(0);
    push(camera, 1);
    came += received_all(*client);
    ASSERT_TRUE(camera.drained(5));
    const GigeCounts sent = camera.counts();
    EXPECT_GT(sent.damaged, 10u);
    EXPECT_EQ(sent.transmitted + sent.damaged, 102u);
    EXPECT_EQ(came + 1, sent.transmitted);
    EXPECT_EQ(client->counts().lost, sent.damaged);
    EXPECT_LE(client->counts().incidents, sent.damaged);  // a picture that lost all its packets is only a gap
}

TEST_F(GigeCameraTest, StalledPicturesComeLateAndComplete) {
    GigeCamera camera{{}};
    const auto client = open_genicam_camera(client_settings(), top_view());
    push(camera, 1);
    EXPECT_EQ(received_all(*client), 1u);
    camera.stall(0.7);
    push(camera, 30);
    EXPECT_EQ(client->read(std::chrono::milliseconds{20}), nullptr);
    EXPECT_EQ(received_all(*client), 30u);
    EXPECT_EQ(client->counts().lost, 0u);
    EXPECT_EQ(client->counts().incidents, 0u);
}

TEST_F(GigeCameraTest, CountsOverflowOfTheQueue) {
    GigeCamera camera{{.queue = 8}};
    const auto client = open_genicam_camera(client_settings(), top_view());
    push(camera, 1);
    EXPECT_EQ(received_all(*client), 1u);
    camera.stall(0.2);
    push(camera, 20);
    ASSERT_TRUE(camera.drained(5));
    push(camera, 1);
    EXPECT_EQ(received_all(*client), 9u);
    ASSERT_TRUE(camera.drained(5));
    const GigeCounts sent = camera.counts();
    EXPECT_EQ(sent.overflow, 12u);
    EXPECT_EQ(sent.transmitted, 10u);
    EXPECT_EQ(client->counts().lost, 12u);
}

TEST_F(GigeCameraTest, ShiftedStampsAreNoLosses) {
    GigeCamera camera{{}};
    const auto client = open_genicam_camera(client_settings(), top_view());
    camera.push(numbered_picture(0, 512, 96), 0);
    camera.shift_stamps(3'000'000'000);
    camera.push(numbered_picture(1, 512, 96), period_ns);
    ASSERT_NE(next_frame(*client), nullptr);
    const FramePtr frame = next_frame(*client);
    ASSERT_NE(frame, nullptr);
    EXPECT_EQ(frame->stamp->n, 3'000'000'000 + period_ns);
    EXPECT_EQ(frame->tick.n, 1);
    EXPECT_TRUE(has(frame->quality, Quality::gap));
    EXPECT_EQ(client->counts().lost, 0u);
    EXPECT_EQ(client->counts().incidents, 1u);
}

TEST_F(GigeCameraTest, SendsNothingWithoutClient) {
    GigeCamera camera{{}};
    push(camera, 3);
    EXPECT_EQ(camera.counts().unasked, 3u);
    EXPECT_EQ(camera.counts().transmitted, 0u);
}

TEST_F(GigeCameraTest, ASoftwareTriggerExposesTheNextPicture) {
    GigeCamera camera{{}};
    genicam::GenicamSettings s = client_settings();
    s.trigger = genicam::CameraTrigger::software;
    s.frame_rate_hz = 50;
    const auto client = open_genicam_camera(s, top_view());
    EXPECT_EQ(client->read(std::chrono::milliseconds{5}), nullptr);  // triggers once
    camera.push(numbered_picture(0, 512, 96), 0);
    camera.push(numbered_picture(1, 512, 96), period_ns);
    EXPECT_EQ(camera.counts().unasked, 1u);
    const FramePtr frame = next_frame(*client);
    ASSERT_NE(frame, nullptr);
    EXPECT_EQ(frame->stamp->n, 0);
}

TEST_F(GigeCameraTest, ASecondCameraAtOneAddressIsRefused) {
    const GigeCamera camera{{}};
    EXPECT_THROW((GigeCamera{{}}), DeviceError);
}

TEST_F(GigeCameraTest, RefusesMissingAddress) {
    EXPECT_THROW((GigeCamera{{.address = "127.0.0.77"}}), DeviceError);
}

TEST_F(GigeCameraTest, RefusesPictureOfWrongSize) {
    GigeCamera camera{{}};
    EXPECT_THROW(camera.push(numbered_picture(0, 512, 95), 0), InputError);
}

}  // namespace
}  // namespace shaker::mock

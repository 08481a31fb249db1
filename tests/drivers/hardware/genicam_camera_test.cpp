#include "drivers/hardware/genicam/genicam_camera.hpp"

#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sched.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <thread>

#include "drivers/errors.hpp"
#include "drivers/hardware/genicam/kind.hpp"
#include "drivers/realtime.hpp"
#include "tests/mock/gige_camera.hpp"
#include "tests/support/devices/mock_cameras.hpp"
#include "tests/support/in_real_time.hpp"

namespace shaker::hardware {
namespace {

using namespace std::chrono_literals;
using test::next_frame, test::numbered_picture, test::same_picture;

constexpr std::int64_t period_ns = 5'000'000;

class GenicamCameraTest : public ::testing::Test {
protected:
    void SetUp() override {
        const std::string refused = test::private_network();
        if (!refused.empty()) GTEST_SKIP() << refused;
        view_.camera = "top";
        settings_.id = "127.0.0.1";
        settings_.frame_rate_hz = 200;
    }
    std::unique_ptr<Camera> open() { return open_genicam_camera(settings_, view_, &granted_); }
    std::string refusal() {
        try {
            open();
        } catch (const DeviceError& error) {
            return error.what();
        }
        return "opened";
    }
    [[nodiscard]] bool told(const std::string& part) const {
        return std::ranges::any_of(
            granted_, [&](const std::string& line) { return line.find(part) != std::string::npos; });
    }
    std::string all_told() const {
        std::string text;
        for (const std::string& line : granted_) text += line + "\n";
        return text;
    }
    genicam::GenicamSettings settings_;
    View view_;
    std::vector<std::string> granted_;
};

TEST_F(GenicamCameraTest, EveryPixelFormatArrivesCodeForCode) {
    for (const genicam::PixelFormat& format : genicam::pixel_formats()) {
        mock::GigeCamera mock{{.width = 64, .height = 6}};
        settings_.pixel_format = format.name;
        const auto camera = open();
        auto picture = std::make_shared<Frame>(*numbered_picture(5, 64, 6, format.bytes_per_pixel()));
        if (format.bits > 8) {
            for (std::size_t i = 0; i < picture->pixels.size(); i += 2) {
                std::uint16_t code = 0;
                std::memcpy(&code, &picture->pixels[i], 2);
                code = static_cast<std::uint16_t>(code & format.full_scale());
                std::memcpy(&picture->pixels[i], &code, 2);
            }
        }
        mock.push(picture, 0);
        const FramePtr frame = next_frame(*camera);
        ASSERT_NE(frame, nullptr) << format.name;
        EXPECT_TRUE(same_picture(*frame, *picture)) << format.name;
        EXPECT_TRUE(told("0 to " + std::to_string(format.full_scale()))) << all_told();
    }
}

TEST_F(GenicamCameraTest, ReportsGrantedAndRequestedSettings) {
    const mock::GigeCamera mock{{}};
    settings_.exposure_s = 0.0005004;  // the mock's register counts microseconds
    settings_.ptp = true;
    settings_.gain = 6;
    settings_.packet_bytes = 1000;
    const auto camera = open();
    EXPECT_TRUE(told("exposure 0.0005 s (requested 0.0005004)")) << all_told();
    EXPECT_TRUE(told("region 512 x 96 at 0, 0 of 512 x 96")) << all_told();
    EXPECT_TRUE(told("trigger from Line0, 200 Hz of at most 2000")) << all_told();
    EXPECT_TRUE(told("gain 6 (requested 6)")) << all_told();
    EXPECT_TRUE(told("PTP on, status Slave")) << all_told();
    EXPECT_TRUE(told("packets of 1000 bytes (requested 1000)")) << all_told();
    EXPECT_EQ(camera->view().exposure_s, 0.0005);
    EXPECT_EQ(camera->view().frame_rate_hz, 200);
    EXPECT_TRUE(mock.requested().ptp);
}

TEST_F(GenicamCameraTest, RefusesUnsupportedSettingsWithRange) {
    const mock::GigeCamera mock{{}};
    const auto refused = [&](auto change, const std::string& part) {
        const genicam::GenicamSettings before = settings_;
        change(settings_);
        const std::string words = refusal();
        EXPECT_NE(words.find("camera \"top\" (127.0.0.1): "), std::string::npos) << words;
        EXPECT_NE(words.find(part), std::string::npos) << words;
        settings_ = before;
    };
    refused([](auto& s) { s.exposure_s = 2; }, "exposure 2 s is not allowed: must be 1e-05 to 1 s");
    refused([](auto& s) { s.frame_rate_hz = 2500; },
            "frame rate 2500 Hz is not allowed: must be 0 to 2000 Hz");
    refused([](auto& s) { s.region_px = {0, 0, 516, 96}; }, "exceeds its sensor of 512 x 96 pixels");
    refused([](auto& s) { s.region_px = {0, 0, 510, 96}; }, "a multiple of 4 up to 512");
    refused([](auto& s) { s.trigger_source = "Line7"; }, "Line0, Line1, Software");
    refused([](auto& s) { s.gain = 25; }, "gain 25 is not allowed: must be 0 to 24");
}

TEST_F(GenicamCameraTest, RefusesMissingCamera) {
    EXPECT_NE(refusal().find("camera \"top\" (127.0.0.1): "), std::string::npos);
}

TEST_F(GenicamCameraTest, RefusesCameraOfAnotherProgram) {
    const mock::GigeCamera mock{{}};
    const auto first = open();
    EXPECT_NE(refusal().find("it is controlled by another program"), std::string::npos);
}

TEST_F(GenicamCameraTest, ChunksAddIdWithoutChangingPicture) {
    mock::GigeCamera mock{{.first_id = 65534}};
    settings_.chunks = true;
    const auto camera = open();
    EXPECT_TRUE(told("chunks FrameID and Timestamp on")) << all_told();
    for (std::uint64_t i = 0; i < 5; ++i) {
        mock.push(numbered_picture(i, 512, 96), static_cast<std::int64_t>(i) * period_ns);
        const FramePtr frame = next_frame(*camera);
        ASSERT_NE(frame, nullptr);
        EXPECT_TRUE(same_picture(*frame, *numbered_picture(i, 512, 96)));
        EXPECT_EQ(frame->tick.n, static_cast<std::int64_t>(i));
    }
    EXPECT_EQ(camera->counts().lost, 0u);
}

// 300 frames are more than the pool has. Frames without a buffer are lost and are counted at the next frame.
TEST_F(GenicamCameraTest, ReadersHoldingAllFramesLoseOnlyPictures) {
    mock::GigeCamera mock{{}};
    const auto camera = open();
    std::vector<FramePtr> held;
    std::uint64_t pushed = 0;
    const auto push = [&] {
        mock.push(numbered_picture(pushed, 512, 96), static_cast<std::int64_t>(pushed) * period_ns);
        ++pushed;
        ASSERT_TRUE(mock.drained(5));
    };
    for (bool full = false; !full && pushed < 1000;) {
        push();
        FramePtr frame = camera->read(500ms);
        full = frame == nullptr;
        if (!full) held.push_back(std::move(frame));
    }
    if (!test::in_real_time && held.size() < 304) return;  // a slow test loses a picture before
    EXPECT_EQ(held.size(), 304u);                          // 48 in the stream and 256 with readers
    held.clear();
    while (camera->read(100ms) != nullptr) FAIL() << "a picture came that found no frame";
    push();
    const FramePtr frame = next_frame(*camera);
    ASSERT_NE(frame, nullptr);
    EXPECT_EQ(frame->tick.n, static_cast<std::int64_t>(pushed) - 1);
    EXPECT_TRUE(has(frame->quality, Quality::gap));
    const DeviceCounts counts = camera->counts();
    EXPECT_EQ(counts.taken + counts.lost, pushed);
}

TEST_F(GenicamCameraTest, StopEndsAReadFromAnotherThread) {
    const mock::GigeCamera mock{{}};
    const auto camera = open();
    std::jthread stopper{[&] {
        std::this_thread::sleep_for(50ms);
        camera->stop();
    }};
    EXPECT_EQ(camera->read(std::chrono::hours{1}), nullptr);  // must return before ctest's time limit
    EXPECT_TRUE(camera->ended());
}

TEST_F(GenicamCameraTest, ReopensUnpluggedCameraAndContinuesTicks) {
    mock::GigeCamera mock{{}};
    const auto camera = open();
    mock.push(numbered_picture(0, 512, 96), 0);
    ASSERT_NE(next_frame(*camera), nullptr);
    const auto began = std::chrono::steady_clock::now();
    mock.unplug();
    mock.push(numbered_picture(1, 512, 96), period_ns);
    mock.plug();
    for (int i = 0; i < 100 && camera->counts().reopened == 0; ++i) EXPECT_EQ(camera->read(100ms), nullptr);
    ASSERT_EQ(camera->counts().reopened, 1u);
    EXPECT_EQ(camera->counts().incidents, 1u);
    EXPECT_TRUE(mock.requested().acquiring);
    // The mock's clock continues, so the stamp determines the tick although ids restart.
    const auto elapsed = std::chrono::steady_clock::now() - began;
    const std::int64_t tick = elapsed / std::chrono::nanoseconds{period_ns};
    mock.push(numbered_picture(2, 512, 96), tick * period_ns);
    const FramePtr frame = next_frame(*camera);
    ASSERT_NE(frame, nullptr);
    EXPECT_TRUE(same_picture(*frame, *numbered_picture(2, 512, 96)));
    EXPECT_EQ(frame->tick.n, tick);
    EXPECT_TRUE(has(frame->quality, Quality::gap));
    EXPECT_EQ(camera->counts().lost, static_cast<std::uint64_t>(tick) - 1);
    EXPECT_EQ(mock.counts().unasked, 1u);
}

// Thread of this process by its name, as the kernel numbers it; 0: none.
int thread_named(const std::string& name) {
    for (const auto& task : std::filesystem::directory_iterator{"/proc/self/task"}) {
        std::ifstream file{task.path() / "comm"};
        std::string found;
        if (std::getline(file, found) && found == name) return std::stoi(task.path().filename());
    }
    return 0;
}

/// Sends empty packets to a UDP port of this computer as fast as a thread can.
std::jthread flood(std::uint16_t port) {
    return std::jthread{[port](const std::stop_token& stop) {
        const int from = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
        sockaddr_in to{};
        to.sin_family = AF_INET;
        to.sin_port = htons(port);
        to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        while (!stop.stop_requested())
            ::sendto(from, "12345678", 8, 0, reinterpret_cast<const sockaddr*>(&to), sizeof to);
        ::close(from);
    }};
}

// Whatever keeps Aravis' thread busy, the threads that stop the drive have the processor.
TEST_F(GenicamCameraTest, AReceiverThatIsFloodedLosesItsPriority) {
    mock::GigeCamera mock{{}};
    const auto camera = open();
    mock.push(numbered_picture(1, 512, 96), 0);
    ASSERT_NE(next_frame(*camera), nullptr);
    if (told("receiving thread: cannot set real-time priority")) GTEST_SKIP() << all_told();
    const int receiver = thread_named("gvsp-top");
    ASSERT_NE(receiver, 0);
    EXPECT_EQ(sched_getscheduler(receiver), SCHED_FIFO);
    sched_param priority{};
    sched_getparam(receiver, &priority);
    EXPECT_LT(priority.sched_priority, fifo_priority::doors);
    const std::array floods{flood(mock.requested().stream_port), flood(mock.requested().stream_port)};
    for (int i = 0; i < 400 && sched_getscheduler(receiver) == SCHED_FIFO; ++i)
        std::this_thread::sleep_for(5ms);
    EXPECT_EQ(sched_getscheduler(receiver), SCHED_OTHER);
}

TEST_F(GenicamCameraTest, ReopensSilentFreeRunningCamera) {
    mock::GigeCamera mock{{}};
    settings_.trigger = genicam::CameraTrigger::free;
    const auto camera = open();
    for (int i = 0; i < 100 && camera->counts().reopened == 0; ++i) EXPECT_EQ(camera->read(100ms), nullptr);
    EXPECT_GE(camera->counts().reopened, 1u);
    EXPECT_GE(camera->counts().incidents, 1u);
}

TEST_F(GenicamCameraTest, ATriggeredCameraMayBeSilent) {
    const mock::GigeCamera mock{{}};
    const auto camera = open();
    EXPECT_EQ(camera->read(1500ms), nullptr);
    EXPECT_EQ(camera->counts().incidents, 0u);
}

// Another camera at the same address answers at once, so there is no time-out of a second or more.
TEST_F(GenicamCameraTest, GivesUpCameraThatReturnsDifferent) {
    std::optional<mock::GigeCamera> mock{std::in_place, mock::GigeCameraSettings{}};
    settings_.give_up_s = 0.1;
    const auto camera = open();
    mock.reset();
    const mock::GigeCamera smaller{{.width = 256}};
    try {
        for (int i = 0; i < 100; ++i) EXPECT_EQ(camera->read(100ms), nullptr);
        FAIL() << "never given up";
    } catch (const DeviceError& error) {
        const std::string words = error.what();
        EXPECT_NE(words.find("camera \"top\" (127.0.0.1): "), std::string::npos) << words;
        EXPECT_NE(words.find("it has been unavailable for"), std::string::npos) << words;
    }
}

TEST_F(GenicamCameraTest, ListsBothCamerasWithCapabilities) {
    const mock::GigeCamera top{{.serial = "TOP"}};
    const mock::GigeCamera side{{.address = "127.0.0.2", .serial = "SIDE", .width = 640, .height = 480}};
    std::map<std::string, nlohmann::json> devices;
    std::string texts;
    for (const ListedDevice& listed : genicam::list_kind({})) {
        const auto device = nlohmann::json::parse(listed.json);
        devices[device.at("id")] = device;
        texts += listed.text;
    }
    EXPECT_EQ(devices["Shaker-Mock-TOP"].at("address"), "127.0.0.1");
    const nlohmann::json& found = devices["Shaker-Mock-SIDE"];
    EXPECT_EQ(found.at("address"), "127.0.0.2");
    EXPECT_EQ(found.at("vendor"), "Shaker");
    EXPECT_EQ(found.at("model"), "Mock");
    EXPECT_EQ(found.at("serial"), "SIDE");
    EXPECT_EQ(found.at("protocol"), "GigEVision");
    EXPECT_FALSE(found.contains("error")) << found;
    EXPECT_EQ(found.at("sensor_px"), nlohmann::json::array({640, 480}));
    EXPECT_EQ(found.at("pixel_formats").size(), 8u);
    EXPECT_EQ(found.at("rate_hz").at(1), 2000);
    EXPECT_EQ(found.at("trigger_sources"), nlohmann::json::array({"Line0", "Line1", "Software"}));
    const char* const said =
        "Shaker-Mock-SIDE\"\n      Shaker Mock at 127.0.0.2, GigEVision\n      640 x 480 px, ";
    EXPECT_NE(texts.find(said), std::string::npos) << texts;
    EXPECT_NE(texts.find(" to 2000 Hz; trigger Line0, Line1, Software\n"), std::string::npos) << texts;
    settings_.id = "Shaker-Mock-SIDE";
    EXPECT_EQ(open()->counts().incidents, 0u);
}

// Two cameras as on the bench for 2 s at 200 pictures per second each, and longer until both have delivered a
// later picture. Stalls of the machine may lose pictures; each lost picture must be counted.
TEST_F(GenicamCameraTest, TwoCamerasAtOnceCountEveryPicture) {
    constexpr int pictures = 400;
    mock::GigeCamera mocks[] = {mock::GigeCamera{{.serial = "TOP"}},
                                mock::GigeCamera{{.address = "127.0.0.2", .serial = "SIDE"}}};
    settings_.packet_bytes = 8000;
    const auto top = open();
    settings_.id = "127.0.0.2";
    const auto side = open();
    std::vector<FramePtr> shots;
    for (std::uint64_t i = 0; i < 8; ++i) shots.push_back(numbered_picture(i, 512, 96));
    std::jthread world{[&](const std::stop_token& stop) {
        auto due = std::chrono::steady_clock::now();
        for (int i = 0; !stop.stop_requested(); ++i, due += std::chrono::nanoseconds{period_ns}) {
            std::this_thread::sleep_until(due);
            for (mock::GigeCamera& mock : mocks)
                mock.push(shots[static_cast<std::size_t>(i) % shots.size()], i * period_ns);
        }
    }};
    std::array<std::int64_t, 2> ticks{-1, -1};  // of the last picture of each
    const auto follow = [&](Camera& camera, std::int64_t& tick) {
        while (tick < pictures - 1) {
            const FramePtr frame = next_frame(camera);
            ASSERT_NE(frame, nullptr) << tick;
            EXPECT_EQ(frame->stamp->n, frame->tick.n * period_ns);
            EXPECT_EQ(has(frame->quality, Quality::gap), frame->tick.n != tick + 1);
            EXPECT_TRUE(same_picture(*frame, *shots[static_cast<std::size_t>(frame->tick.n) % shots.size()]));
            tick = frame->tick.n;
        }
    };
    std::jthread other{[&] { follow(*side, ticks[1]); }};
    follow(*top, ticks[0]);
    other.join();
    world.request_stop();
    world.join();
    for (const bool first : {true, false}) {
        const DeviceCounts counts = (first ? top : side)->counts();
        const auto all = static_cast<std::uint64_t>(ticks[first ? 0 : 1] + 1);
        EXPECT_EQ(counts.taken + counts.lost, all);
        std::printf("%s: %llu pictures of 512 x 96 at 200 Hz: %llu taken, %llu lost\n",
                    first ? "top" : "side", static_cast<unsigned long long>(all),
                    static_cast<unsigned long long>(counts.taken),
                    static_cast<unsigned long long>(counts.lost));
    }
}

}  // namespace
}  // namespace shaker::hardware

// The contract of the seam, the same for every Dac, Accelerometer and Camera: ticks never step back, a gap is
// marked, counts grow, stop() unblocks, ended() is final.
// To add a device: a row in accelerometers, cameras or dacs.
#include <gtest/gtest.h>

#include <atomic>
#include <functional>
#include <future>
#include <opencv2/videoio.hpp>
#include <optional>
#include <thread>

#include "drivers/devices.hpp"
#include "drivers/footage/csv_accelerometer.hpp"
#include "drivers/hardware/alsa/alsa_dac.hpp"
#include "drivers/hardware/genicam/genicam_camera.hpp"
#include "drivers/hardware/video/video_camera.hpp"
#include "drivers/simulated/world.hpp"
#include "tests/drivers/hardware/iio_bench.hpp"
#include "tests/mock/gige_camera.hpp"
#include "tests/support/devices/mock_cameras.hpp"
#include "tests/support/devices/mock_dac.hpp"
#include "tests/support/program.hpp"
#include "tests/support/recording/small_recording.hpp"

namespace shaker {
namespace {

using namespace std::chrono_literals;
using simulated::FaultKind;
using simulated::World;

/// A device and what feeds it, which outlives it.
template <class Device>
struct Fed {
    std::shared_ptr<void> source{};
    std::unique_ptr<Device> device{};
    std::function<void()> feed = [] {};  // before each read
    std::function<void()> lose = [] {};  // data are lost from now on for a while
    bool loses = true;                   // some data are lost in the course of the test
    std::string refused{};               // why this machine cannot have the device
};

template <class Device>
struct Kind {
    const char* name;
    Fed<Device> (*open)();
};
const auto name_of = [](const auto& kind) { return std::string{kind.param.name}; };

simulated::Scene scene_with_losses() {
    simulated::Scene scene = simulated::paper_scene(simulated::Detail::positions);
    scene.faults = {{FaultKind::drop, 0.2, 0, 100, {}},
                    {FaultKind::camera_stall, 0.2, 0.05, 0, {}},
                    {FaultKind::underrun, 0.2, 0, 480, {}}};
    return scene;
}

/// A simulated bench that plays silence with the trigger of the cameras, 5 ms at a time.
struct Bench {
    explicit Bench(World::Pace pace) : world{scene_with_losses(), pace}, rig{world.rig()} {}
    void play(Dac& dac) {
        std::vector<double> still(dac.info().block_frames), trigger(still.size());
        trigger.front() = 1;
        dac.write(still, trigger);
    }
    World world;
    Rig rig;
};

/// Its devices but the one under test have a thread each.
struct ThreadedBench : Bench {
    ThreadedBench() : Bench{World::Pace::paced} {}
    ~ThreadedBench() {
        if (dac != nullptr) dac->stop();
    }
    void begin() {
        dac = rig.dac.get();
        if (rig.accelerometer)
            threads.emplace_back([this](const std::stop_token& stop) {
                AccelBlock block;
                while (!stop.stop_requested()) rig.accelerometer->read(block, 1ms);
            });
        for (const auto& camera : rig.cameras)
            if (camera)
                threads.emplace_back([&camera](const std::stop_token& stop) {
                    while (!stop.stop_requested()) camera->read(1ms);
                });
        if (dac != nullptr)
            threads.emplace_back([this](const std::stop_token& stop) {
                while (!stop.stop_requested()) play(*dac);
            });
    }
    Dac* dac = nullptr;
    std::vector<std::jthread> threads;
};

template <class Device>
Fed<Device> lockstep(std::unique_ptr<Device> (*take)(Rig&)) {
    auto bench = std::make_shared<Bench>(World::Pace::lockstep);
    auto device = take(bench->rig);
    return {bench, std::move(device), [b = bench.get()] { b->play(*b->rig.dac); }};
}

template <class Device>
Fed<Device> threaded(std::unique_ptr<Device> (*take)(Rig&)) {
    auto bench = std::make_shared<ThreadedBench>();
    auto device = take(bench->rig);
    bench->begin();
    return {bench, std::move(device)};
}

/// A recording whose streams have a gap each.
std::shared_ptr<recorded::RecordingReader> recording() {
    test::Session session = test::small_session();
    for (auto& frames : session.frames)
        for (std::size_t i = 0; i < frames.size(); ++i) {
            Frame frame = *frames[i];
            const bool last = i + 1 == frames.size();
            frame.tick = {static_cast<std::int64_t>(last ? 2 * i : i)};
            frame.quality = last ? Quality::gap : Quality::good;
            frames[i] = std::make_shared<const Frame>(std::move(frame));
        }
    const auto file = test::fresh_folder() / "seam.nxs";
    test::write_session(session, file);
    return std::make_shared<recorded::RecordingReader>(file);
}

std::unique_ptr<Accelerometer> accelerometer_of(Rig& rig) { return std::move(rig.accelerometer); }
std::unique_ptr<Camera> camera_of(Rig& rig) { return std::move(rig.cameras.front()); }
std::unique_ptr<Dac> dac_of(Rig& rig) { return std::move(rig.dac); }

template <class Device>
Fed<Device> replayed(std::unique_ptr<Device> (*take)(Rig&)) {
    const auto reader = recording();
    Rig rig = recorded::replay_rig(*reader, reader->header(), true);
    return {reader, take(rig)};
}

Fed<Accelerometer> csv_accelerometer() {
    const auto folder = test::fresh_folder();
    std::ofstream csv{folder / "a.csv"};
    csv << "t,x,y,z\n";
    for (int i = 0; i < 800; ++i)
        csv << (i < 400 ? i : i + 200) / 4000.0 << "," << 0.01 * (i % 7) << ",0,9.8\n";
    csv.close();
    auto open =
        footage::open_csv_accelerometer({.file = folder / "a.csv", .time = "t", .axes = {"x", "y", "z"}});
    return {nullptr, std::move(open.accelerometer)};
}

Fed<Accelerometer> iio_accelerometer() {
    auto bench = std::make_shared<test::IioBench>();
    auto device = iio::open_iio_accelerometer(test::settings_for(bench->iiod));
    return {bench, std::move(device), [] {}, [b = bench.get()] { b->iiod.drop(300); }};
}

struct MockedCamera {
    MockedCamera() : mock{{.width = 32, .height = 8}} {}
    void push() {
        mock.push(test::numbered_picture(n, 32, 8), static_cast<std::int64_t>(5'000'000 * n));
        ++n;
    }
    mock::GigeCamera mock;
    std::uint64_t n = 0;
};

Fed<Camera> gige_camera() {
    if (std::string refused = test::private_network(); !refused.empty()) {
        Fed<Camera> none;
        none.refused = refused;
        return none;
    }
    auto source = std::make_shared<MockedCamera>();
    genicam::GenicamSettings settings;
    settings.id = "127.0.0.1";
    settings.frame_rate_hz = 200;
    View view;
    view.camera = "top";
    auto device = genicam::open_genicam_camera(settings, view);
    return {source, std::move(device), [s = source.get()] { s->push(); },
            [s = source.get()] {
                s->mock.drop(3);
                for (int i = 0; i < 3; ++i) s->push();
            }};
}

Fed<Camera> movie() {
    video::VideoSettings settings;
    settings.file = test::fresh_folder() / "movie.avi";
    {
        cv::VideoWriter writer{settings.file.string(), cv::CAP_FFMPEG,
                               cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), 50, cv::Size{48, 32}};
        for (int i = 0; i < 60; ++i) writer.write(cv::Mat(32, 48, CV_8UC3, cv::Scalar::all(i)));
    }
    settings.paced = false;
    View view;
    view.camera = "top";
    Fed<Camera> fed{nullptr, video::open_video_camera(settings, view)};
    fed.loses = false;
    return fed;
}

Fed<Dac> alsa_dac() {
    auto mock = std::make_shared<test::MockDac>();
    auto device = std::make_unique<alsa::AlsaDac>(mock->settings);
    return {mock, std::move(device), [m = mock.get()] { m->listen(); },
            [m = mock.get()] { m->converter.cause_underrun(); }};
}

constexpr auto patience = 5s;

/// Reads until `enough` or the end of the data; false after some seconds.
template <class Device>
bool read_until(Fed<Device>& fed, const std::function<bool()>& enough, const std::function<bool()>& read) {
    for (const auto begin = std::chrono::steady_clock::now();
         std::chrono::steady_clock::now() < begin + 2 * patience;) {
        if (enough()) return true;
        fed.feed();
        if (!read() && fed.device->ended()) return true;
    }
    return false;
}

/// A thread that calls `wait` again and again until stop() has been called ends within some seconds.
template <class Device>
bool stop_ends(Device& device, const std::function<void()>& wait) {
    std::atomic<bool> stopped{false};
    auto waited = std::async(std::launch::async, [&] {
        while (!stopped) wait();
    });
    std::this_thread::sleep_for(100ms);
    device.stop();
    stopped = true;
    return waited.wait_for(patience) == std::future_status::ready;
}

/// The laws of the ticks of a stream, and its counts.
class TickStream {
public:
    void take(std::int64_t tick, std::int64_t size, Quality quality, const DeviceCounts& now) {
        const std::int64_t step = next_ ? tick - *next_ : 0;
        EXPECT_GE(step, 0) << "the ticks step back at " << tick;
        EXPECT_TRUE(!next_ || (step > 0) == has(quality, Quality::gap)) << "mark of a gap at " << tick;
        EXPECT_GE(now.taken, counts_.taken);
        EXPECT_GE(now.lost, counts_.lost);
        counts_ = now;
        gaps_ += step > 0;
        next_ = tick + size;
        taken_ += size;
    }
    void expect(bool loses) const {
        EXPECT_EQ(gaps_ > 0, loses);
        EXPECT_GE(counts_.taken, static_cast<std::uint64_t>(taken_));
        EXPECT_EQ(counts_.lost > 0, loses);
    }
    [[nodiscard]] std::int64_t taken() const { return taken_; }
    [[nodiscard]] std::int64_t gaps() const { return gaps_; }

private:
    std::optional<std::int64_t> next_;
    std::int64_t gaps_ = 0, taken_ = 0;
    DeviceCounts counts_;
};

class AccelerometerContractTest : public testing::TestWithParam<Kind<Accelerometer>> {
protected:
    void SetUp() override {
        fed_ = GetParam().open();
        if (!fed_.refused.empty()) GTEST_SKIP() << fed_.refused;
    }
    Fed<Accelerometer> fed_;
    AccelBlock block_;
};

TEST_P(AccelerometerContractTest, TicksNeverStepBackAndGapsAreMarked) {
    TickStream stream;
    bool lost = false;
    EXPECT_TRUE(read_until(
        fed_, [&] { return stream.taken() > 4000 && stream.gaps() > 0; },
        [&] {
            if (stream.taken() > 600 && !std::exchange(lost, true)) fed_.lose();
            if (!fed_.device->read(block_, 50ms)) return false;
            stream.take(block_.first.n, block_.size, block_.quality, fed_.device->counts());
            return true;
        }));
    stream.expect(fed_.loses);
}

TEST_P(AccelerometerContractTest, StopUnblocksARead) {
    EXPECT_TRUE(stop_ends(*fed_.device, [&] { fed_.device->read(block_, 60s); }));
}

TEST_P(AccelerometerContractTest, EndedIsFinal) {
    fed_.device->stop();
    for (int i = 0; i < 10000 && !fed_.device->ended(); ++i) fed_.device->read(block_, 0ms);
    for (int i = 0; i < 3; ++i) {
        EXPECT_TRUE(fed_.device->ended());
        EXPECT_FALSE(fed_.device->read(block_, 20ms));
    }
}

INSTANTIATE_TEST_SUITE_P(
    Devices, AccelerometerContractTest,
    testing::Values(Kind<Accelerometer>{"simulated", [] { return lockstep(accelerometer_of); }},
                    Kind<Accelerometer>{"simulated_threads", [] { return threaded(accelerometer_of); }},
                    Kind<Accelerometer>{"recorded", [] { return replayed(accelerometer_of); }},
                    Kind<Accelerometer>{"csv", csv_accelerometer},
                    Kind<Accelerometer>{"iio", iio_accelerometer}),
    name_of);

class CameraContractTest : public testing::TestWithParam<Kind<Camera>> {
protected:
    void SetUp() override {
        fed_ = GetParam().open();
        if (!fed_.refused.empty()) GTEST_SKIP() << fed_.refused;
    }
    Fed<Camera> fed_;
};

TEST_P(CameraContractTest, TicksNeverStepBackAndGapsAreMarked) {
    TickStream stream;
    bool lost = false;
    EXPECT_TRUE(read_until(
        fed_, [&] { return stream.taken() > 100 && stream.gaps() > 0; },
        [&] {
            if (stream.taken() > 20 && !std::exchange(lost, true)) fed_.lose();
            const FramePtr frame = fed_.device->read(50ms);
            if (frame) stream.take(frame->tick.n, 1, frame->quality, fed_.device->counts());
            return frame != nullptr;
        }));
    stream.expect(fed_.loses);
}

TEST_P(CameraContractTest, StopUnblocksARead) {
    EXPECT_TRUE(stop_ends(*fed_.device, [&] { fed_.device->read(60s); }));
}

TEST_P(CameraContractTest, EndedIsFinal) {
    fed_.device->stop();
    for (int i = 0; i < 10000 && !fed_.device->ended(); ++i) fed_.device->read(0ms);
    for (int i = 0; i < 3; ++i) {
        EXPECT_TRUE(fed_.device->ended());
        EXPECT_EQ(fed_.device->read(20ms), nullptr);
    }
}

INSTANTIATE_TEST_SUITE_P(Devices, CameraContractTest,
                         testing::Values(Kind<Camera>{"simulated", [] { return lockstep(camera_of); }},
                                         Kind<Camera>{"simulated_threads",
                                                      [] { return threaded(camera_of); }},
                                         Kind<Camera>{"recorded", [] { return replayed(camera_of); }},
                                         Kind<Camera>{"gige", gige_camera}, Kind<Camera>{"movie", movie}),
                         name_of);

class DacContractTest : public testing::TestWithParam<Kind<Dac>> {
protected:
    void SetUp() override { fed_ = GetParam().open(); }
    PlayTime write() {
        const std::vector<double> still(fed_.device->info().block_frames);
        return fed_.device->write(still, still);
    }
    Fed<Dac> fed_;
};

TEST_P(DacContractTest, TicksNeverStepBackAndAnUnderrunIsReported) {
    std::int64_t last = std::numeric_limits<std::int64_t>::min();
    std::int64_t lost = 0, played = 0;
    DeviceCounts before;
    for (int i = 0; i < 100; ++i) {
        if (i == 50) fed_.lose();
        const PlayTime p = write();
        EXPECT_GE(p.tick.n, last);
        last = p.tick.n;
        lost += p.lost;
        played += static_cast<std::int64_t>(fed_.device->info().block_frames);
        const DeviceCounts now = fed_.device->counts();
        EXPECT_GE(now.taken, before.taken);
        EXPECT_GE(now.lost, before.lost);
        before = now;
    }
    EXPECT_GT(lost, 0);
    EXPECT_GT(before.taken, 0U);
    EXPECT_GT(before.lost, 0U);
    EXPECT_GT(before.incidents, 0U);
    EXPECT_LE(before.taken, static_cast<std::uint64_t>(played));
}

TEST_P(DacContractTest, StopUnblocksAWrite) {
    EXPECT_TRUE(stop_ends(*fed_.device, [&] { write(); }));
}

INSTANTIATE_TEST_SUITE_P(Devices, DacContractTest,
                         testing::Values(Kind<Dac>{"simulated", [] { return lockstep(dac_of); }},
                                         Kind<Dac>{"simulated_threads", [] { return threaded(dac_of); }},
                                         Kind<Dac>{"alsa", alsa_dac}),
                         name_of);

}  // namespace
}  // namespace shaker

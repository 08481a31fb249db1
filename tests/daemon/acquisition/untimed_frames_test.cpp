// Frames of cameras that stamp by their own clock: their times follow from the stamps of the recording.
#include <gtest/gtest.h>

#include <cmath>

#include "daemon/acquisition/streams.hpp"

namespace shaker::acquisition {
namespace {

constexpr double dac_rate_hz = 48000, frame_rate_hz = 100, exposure_s = 1e-3;
constexpr std::int64_t block = 480;

// A DAC that triggers one camera, whose own clock runs 50 ppm fast.
class TriggeredCamera {
public:
    TriggeredCamera() {
        streams.dac_rate_hz = dac_rate_hz;
        View view;
        view.camera = "top";
        view.frame_rate_hz = frame_rate_hz;
        view.exposure_s = exposure_s;
        view.dac_triggered = true;
        view.mm_per_px = 0.1;
        view.targets.resize(1);
        streams.cameras.push_back({.view = view, .first_track = 0, .untimed = {}});
        streams.tracks.push_back({"top", view.targets[0], {}});
        streams.timebase = empty_timebase(streams);
    }

    // One block of the DAC for each frame.
    void play(int frames, bool final = false) {
        for (int i = 0; i < frames; ++i, ++played_) {
            const double start_s = static_cast<double>(played_) / frame_rate_hz;
            add(streams, PlayTime{{played_ * block}, at(start_s), 0});
            Frame frame;
            frame.tick = {played_};
            frame.stamp = CameraStamp{std::llround(1e9 * (77 + (1 + 50e-6) * start_s))};
            frame.arrived = at(start_s + 0.002);
            const MasterTime time = add_stamps(streams, 0, frame, final);
            add_fixes(streams, 0, frame, {tracking::Fix{}}, time, final);
        }
    }
    void expect_exact_times(const Streams& taken, std::int64_t first) const {
        for (const tracking::Track& t : taken.tracks[0].tracks)
            EXPECT_NEAR(seconds(t.time), static_cast<double>(t.tick.n) / frame_rate_hz + exposure_s / 2,
                        1e-9);
        EXPECT_EQ(taken.tracks[0].tracks.front().tick.n, first);
    }

    Streams streams;

private:
    static HostTime at(double s) {
        return HostTime{std::chrono::duration_cast<std::chrono::nanoseconds>(Seconds{5 + s})};
    }
    std::int64_t played_ = 0;
};

TEST(UntimedFramesTest, SettleOnTheirPulses) {
    TriggeredCamera bench;
    bench.play(300);
    std::vector<std::string> notes;
    settle_times(bench.streams, notes);
    EXPECT_EQ(notes, std::vector<std::string>{});
    bench.expect_exact_times(bench.streams, 0);
}

// The stamps before a recording are not in it: frames are counted and settled from its begin.
TEST(UntimedFramesTest, SettleInARecordingThatBeganLater) {
    TriggeredCamera bench;
    bench.play(200);
    forget(bench.streams);
    bench.play(300);
    ASSERT_EQ(bench.streams.cameras[0].untimed.size(), 300U);
    Streams recorded = hand_over(bench.streams, INFINITY);
    EXPECT_EQ(recorded.timebase.camera(0).stamps, 300U);
    std::vector<std::string> notes;
    settle_times(recorded, notes);
    EXPECT_EQ(notes, std::vector<std::string>{});
    bench.expect_exact_times(recorded, 200);
    EXPECT_EQ(bench.streams.timebase.camera(0).stamps, 500U) << "the bench keeps its clocks";
}

// Tracks that no measurement needs leave the memory; a recording still gets the times of all frames.
TEST(UntimedFramesTest, SettleAfterTracksWereDropped) {
    for (const bool recorded : {true, false}) {
        TriggeredCamera bench;
        bench.play(300);
        drop_before(bench.streams, 2.6);
        if (!recorded) drop_stamps(bench.streams);
        bench.play(100);
        const CameraStream& camera = bench.streams.cameras[0];
        EXPECT_EQ(camera.untimed.size(), recorded ? 400U : 400U - camera.dropped);
        std::vector<std::string> notes;
        settle_times(bench.streams, notes);
        EXPECT_EQ(notes, std::vector<std::string>{});
        bench.expect_exact_times(bench.streams, static_cast<std::int64_t>(camera.dropped));
        EXPECT_EQ(camera.dropped, 160U);
        ASSERT_EQ(camera.times_s.size(), camera.untimed.size());
        EXPECT_NEAR(camera.times_s.back(), 399 / frame_rate_hz + exposure_s / 2, 1e-9);
        EXPECT_NEAR(camera.times_s.front(), (recorded ? 0 : 160) / frame_rate_hz + exposure_s / 2, 1e-9);
    }
}

// A bench on call gives each frame its time at once; its recording holds them and settles nothing.
TEST(UntimedFramesTest, FinalTimesAreNotSettledAgain) {
    TriggeredCamera bench;
    bench.play(200, true);
    forget(bench.streams);
    bench.play(300, true);
    Streams recorded = hand_over(bench.streams, INFINITY);
    EXPECT_EQ(recorded.timebase.frames(0), 0U);
    EXPECT_EQ(recorded.timebase.camera(0).stamps, 300U);
    std::vector<std::string> notes;
    settle_times(recorded, notes);
    EXPECT_EQ(notes, std::vector<std::string>{});
    bench.expect_exact_times(recorded, 200);
}

}  // namespace
}  // namespace shaker::acquisition

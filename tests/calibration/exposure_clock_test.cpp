#include "calibration/clocks/exposure_clock.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "drivers/trigger_train.hpp"

namespace shaker::calibration {
namespace {

constexpr double dac_hz = 48000;
constexpr std::int64_t host_zero_ns = 4'000'000'000'000;
constexpr double dac_ppm = 37.5, camera_ppm = -80;

HostTime host(double s) { return HostTime{std::chrono::nanoseconds{host_zero_ns + std::llround(1e9 * s)}}; }
HostTime host_of_sample(double n) { return host(n / (dac_hz * (1 + 1e-6 * dac_ppm))); }

ClockMap<DacClock> dac_map() { return {{0}, host(0), 1e9 / (dac_hz * (1 + 1e-6 * dac_ppm))}; }

// A camera whose clock has another origin and another rate. Frames arrive at least 3.2 ms after the start of
// their exposure, with up to 2 ms of jitter and stalls of 60 ms.
struct TestCamera {
    std::mt19937_64 rng{5};
    std::exponential_distribution<double> jitter{2000};
    double clock_jump_s = 0;

    FrameStamp frame(std::int64_t tick, double sample, bool stamped = true) {
        const double late = 3.2e-3 + std::min(2e-3, jitter(rng)) + (tick % 97 > 90 ? 60e-3 : 0);
        const HostTime start = host_of_sample(sample);
        const double s = 1e-9 * static_cast<double>(start.time_since_epoch().count() - host_zero_ns);
        FrameStamp f{{tick}, {}, start + std::chrono::nanoseconds{std::llround(1e9 * late)}};
        if (stamped)
            f.stamp = CameraStamp{std::llround(1e9 * ((s + 17) * (1 + 1e-6 * camera_ppm) + clock_jump_s))};
        return f;
    }
};

View view_at(double fps, bool triggered) {
    return {.camera = "top",
            .frame_rate_hz = fps,
            .exposure_s = 4e-4,
            .dac_triggered = triggered,
            .trigger_delay_s = triggered ? 5e-6 : 0,
            .arrival_delay_s = triggered ? 0 : 3.2e-3,
            .targets = {}};
}

TEST(ExposureClockTest, TriggeredFrameIsExactlyOnItsPulse) {
    const double fps = 190;  // a pulse every 252.6 samples; frames arrive most of a frame late and worse
    ExposureClock clock{view_at(fps, true), dac_hz};
    TestCamera camera;
    std::int64_t tick = 0;
    for (std::int64_t k = 0; k < 3000; ++k) {
        if (k > 200 && k % 50 < 7) continue;  // pulses without a frame, with or without a step of the count
        if (k % 100 == 10) tick += 3;
        const auto sample = TriggerTrain::pulse(k, dac_hz, fps);
        const FrameStamp f = camera.frame(k <= 200 ? k : tick++, static_cast<double>(sample) + 0.3);
        clock.add(f);
        const double expected = static_cast<double>(sample) / dac_hz + 5e-6 + 2e-4;
        const std::size_t number = k <= 200 ? static_cast<std::size_t>(k) : 0;
        if (k <= 200)
            ASSERT_NEAR(seconds(clock.mid_exposure(number, f, dac_map())), expected, 1e-12) << k;
        else
            ASSERT_NEAR(seconds(clock.mid_exposure(1000000, f, dac_map())), expected, 1e-12) << k;
    }
    EXPECT_EQ(clock.jumps(), 0U);
}

// A client that has just started receives its first pictures late, so none of them shows the shortest delay.
TEST(ExposureClockTest, LateFirstFramesAreNotJump) {
    for (const double slow_s : {2.5e-3, 40e-3}) {
        ExposureClock clock{view_at(200, true), dac_hz};
        TestCamera camera;
        std::vector<FrameStamp> frames;
        for (std::int64_t k = 0; k < 500; ++k) {
            frames.push_back(camera.frame(k, static_cast<double>(TriggerTrain::pulse(k, dac_hz, 200))));
            const double late = slow_s * std::max(0.0, 1 - static_cast<double>(k) / 30);
            frames.back().arrived += std::chrono::nanoseconds{std::llround(1e9 * late)};
            clock.add(frames.back());
        }
        EXPECT_EQ(clock.jumps(), 0U);
        for (std::size_t k = 0; k < frames.size(); ++k)
            ASSERT_NEAR(seconds(clock.mid_exposure(k, frames[k], dac_map())),
                        static_cast<double>(k) / 200 + 5e-6 + 2e-4, 1e-12)
                << "first frame " << slow_s << " s late, frame " << k;
    }
}

TEST(ExposureClockTest, SlowComputerIsNotJump) {
    ExposureClock clock{view_at(200, true), dac_hz};
    TestCamera camera;
    std::vector<FrameStamp> frames;
    for (std::int64_t k = 0; k < 3000; ++k) {
        frames.push_back(camera.frame(k, static_cast<double>(TriggerTrain::pulse(k, dac_hz, 200))));
        if (k < 700 || (k > 1000 && k < 1800))
            frames.back().arrived += std::chrono::milliseconds{130 + k % 50};
        clock.add(frames.back());
    }
    EXPECT_EQ(clock.jumps(), 0U);
    for (std::size_t k = 0; k < frames.size(); ++k)
        ASSERT_NEAR(seconds(clock.mid_exposure(k, frames[k], dac_map())),
                    static_cast<double>(k) / 200 + 5e-6 + 2e-4, 1e-12)
            << "frame " << k;
}

TEST(ExposureClockTest, FreeRunningCameraIsAccurateTo20us) {
    ExposureClock clock{view_at(200, false), dac_hz};
    TestCamera camera;
    double worst = 0;
    for (std::int64_t k = 0; k < 2000; ++k) {
        const double sample = static_cast<double>(k) * 240.003;
        const FrameStamp f = camera.frame(k, sample);
        clock.add(f);
        const double t = seconds(clock.mid_exposure(static_cast<std::size_t>(k), f, dac_map()));
        if (k > 1000) worst = std::max(worst, std::abs(t - sample / dac_hz - 2e-4));
    }
    EXPECT_LT(worst, 20e-6);  // the shortest of 1000 exponential delays of mean 500 us, and the rate's error
}

TEST(ExposureClockTest, JumpInEitherDirectionStartsNewEpoch) {
    for (const double jump : {0.012, -0.012, -500.0}) {
        const double fps = 200;
        ExposureClock clock{view_at(fps, true), dac_hz};
        TestCamera camera;
        std::vector<FrameStamp> frames;
        for (std::int64_t k = 0; k < 1000; ++k) {
            if (k == 600) camera.clock_jump_s = jump;
            frames.push_back(camera.frame(k, static_cast<double>(TriggerTrain::pulse(k, dac_hz, fps))));
            clock.add(frames.back());
        }
        EXPECT_EQ(clock.jumps(), 1U) << jump;
        for (std::size_t k = 0; k < frames.size(); ++k)
            ASSERT_NEAR(seconds(clock.mid_exposure(k, frames[k], dac_map())),
                        static_cast<double>(k) / fps + 5e-6 + 2e-4, 1e-12)
                << "jump " << jump << " frame " << k;
    }
}

TEST(ExposureClockTest, CameraWithoutClockUsesItsCount) {
    ExposureClock clock{view_at(100, false), dac_hz};
    TestCamera camera;
    double worst = 0;
    for (std::int64_t k = 0; k < 1000; ++k) {
        const FrameStamp f = camera.frame(k, static_cast<double>(k) * 480, false);
        clock.add(f);
        const double t = seconds(clock.mid_exposure(static_cast<std::size_t>(k), f, dac_map()));
        if (k > 500) worst = std::max(worst, std::abs(t - 0.01 * static_cast<double>(k) - 2e-4));
    }
    EXPECT_LT(worst, 50e-6);
}

}  // namespace
}  // namespace shaker::calibration

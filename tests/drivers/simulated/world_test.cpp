#include "drivers/simulated/world.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <cstring>
#include <thread>

#include "tests/support/control/bench_drive.hpp"

namespace shaker::simulated {
namespace {

constexpr std::size_t block = 240;

struct Heard {
    std::vector<AccelBlock> blocks;
    std::vector<std::vector<Frame>> frames;
    std::vector<PlayTime> played;
    std::vector<PoseTruth> truth;
};

Scene quick(double fps = 200) {
    Scene s = paper_scene();
    for (CameraTruth& c : s.cameras) c.view.frame_rate_hz = fps;
    return s;
}

Heard play(const Scene& scene, long blocks, std::size_t size = block) {
    World world{scene};
    Rig rig = world.rig();
    Heard h;
    h.frames.resize(rig.cameras.size());
    const auto volts = test::volts_for(scene, {});
    const long every = std::lround(scene.dac_rate_hz / scene.cameras[0].view.frame_rate_hz);
    std::vector<double> trigger(size);
    for (long k = 0; k < blocks; ++k) {
        const long n0 = k * static_cast<long>(size);
        const auto drive = test::samples(volts, 20, scene.dac_rate_hz, n0, size);
        for (std::size_t i = 0; i < size; ++i) trigger[i] = (n0 + static_cast<long>(i)) % every == 0 ? 1 : 0;
        h.played.push_back(rig.dac->write(drive, trigger));
        for (AccelBlock b; rig.accelerometer->read(b, {});) h.blocks.push_back(b);
        for (std::size_t c = 0; c < rig.cameras.size(); ++c)
            while (FramePtr f = rig.cameras[c]->read({})) h.frames[c].push_back(*f);
    }
    h.truth = world.truth(0);
    return h;
}

TEST(WorldTest, GivesSameBytesForAnyBlockSize) {
    const Heard a = play(quick(), 300), b = play(quick(), 300), c = play(quick(), 600, 120);
    for (const Heard* other : {&b, &c}) {
        ASSERT_EQ(a.blocks.size(), other->blocks.size());
        for (std::size_t i = 0; i < a.blocks.size(); ++i) {
            EXPECT_EQ(a.blocks[i].counts, other->blocks[i].counts);
            EXPECT_EQ(a.blocks[i].arrived, other->blocks[i].arrived);
        }
        for (std::size_t k = 0; k < a.frames.size(); ++k) {
            ASSERT_EQ(a.frames[k].size(), other->frames[k].size());
            for (std::size_t i = 0; i < a.frames[k].size(); ++i)
                EXPECT_EQ(a.frames[k][i].pixels, other->frames[k][i].pixels);
        }
    }
    Scene seeded = quick();
    seeded.seed = 2;
    EXPECT_NE(play(seeded, 300).blocks[3].counts, a.blocks[3].counts);
}

TEST(WorldTest, TheAccelerometerRunsOnItsOwnClock) {
    Scene s = quick();
    s.accelerometer.clock_ppm = 500;
    const Heard h = play(s, 2000);  // 10 s
    const auto span = h.blocks.back().arrived - h.blocks.front().arrived;
    const double rate = static_cast<double>(h.blocks.back().first.n - h.blocks.front().first.n) /
                        std::chrono::duration<double>(span).count();
    EXPECT_NEAR(rate / 4000 - 1, 500e-6, 100e-6);  // stamps scatter by 0.1 ms in 10 s: 14 ppm
}

TEST(WorldTest, TriggerExposesFrames) {
    const Heard h = play(quick(), 400);
    ASSERT_GT(h.frames[0].size(), 300U);
    for (std::size_t i = 0; i < h.frames[0].size(); ++i) {
        const Frame& f = h.frames[0][i];
        EXPECT_EQ(f.tick.n, static_cast<std::int64_t>(i));
        EXPECT_NEAR(seconds(*f.mid_exposure), static_cast<double>(i) / 200 + 150e-6, 1e-12);
        EXPECT_EQ(h.truth[i].time, *f.mid_exposure);
    }
}

TEST(WorldTest, SensorMeasuresMotionOfBase) {
    Scene s = quick();
    s.accelerometer.noise_mps2_rthz = 0;
    s.accelerometer.yaw_deg = 0;
    const Heard h = play(s, 600);
    // The true position seen by the cameras is the double integral of the acceleration: compare amplitudes at
    // w by a_1 = -w^2 x_1.
    std::complex<double> a1 = 0, x1 = 0;
    const double w = two_pi * 20,
                 scale = s.accelerometer.range_mps2 / std::ldexp(1.0, s.accelerometer.bits - 1);
    int n = 0;
    for (std::size_t k = h.blocks.size() - 50; k < h.blocks.size(); ++k)
        for (int i = 0; i < 64; ++i, ++n)  // 3200 samples: 16 periods
            a1 += scale * h.blocks[k].counts[static_cast<std::size_t>(i)][0] * std::polar(1.0, -w * n / 4000);
    a1 *= 2.0 / n;
    int m = 0;
    for (std::size_t k = h.truth.size() - 160; k < h.truth.size(); ++k, ++m)
        x1 += h.truth[k].base * std::polar(1.0, -w * m / 200);
    x1 *= 2.0 / m;
    EXPECT_NEAR(std::abs(a1) / (w * w * std::abs(x1)), 1, 2e-3);  // 37.5 ppm and the low-pass: 1e-4 together
}

TEST(WorldTest, UnreadQueueDropsAndMarksData) {
    World world{quick(2000)};
    Rig rig = world.rig();
    std::vector<double> zero(48000), trigger(48000);
    for (std::size_t i = 0; i < trigger.size(); i += 24) trigger[i] = 1;
    for (int k = 0; k < 4; ++k) rig.dac->write(zero, trigger);  // 8000 exposures, room for 4096
    int frames = 0, gaps = 0;
    while (FramePtr f = rig.cameras[0]->read({})) ++frames;
    rig.dac->write(zero, trigger);
    std::int64_t first = -1;
    while (FramePtr f = rig.cameras[0]->read({})) {
        if (first < 0) first = f->tick.n;
        gaps += has(f->quality, Quality::gap) ? 1 : 0;
    }
    EXPECT_EQ(frames, 4096);
    EXPECT_GE(first, 7999);
    EXPECT_EQ(gaps, 1);
}

TEST(WorldTest, KeepingAllBuffersLosesMarkedFrames) {
    World world{quick(2000)};
    Rig rig = world.rig();
    std::vector<double> zero(48000), trigger(48000);
    for (std::size_t i = 0; i < trigger.size(); i += 24) trigger[i] = 1;
    rig.dac->write(zero, trigger);  // 2000 exposures
    std::vector<FramePtr> kept;
    while (FramePtr f = rig.cameras[0]->read({})) kept.push_back(f);
    EXPECT_EQ(kept.size(), 256U);
    kept.clear();
    const FramePtr next = rig.cameras[0]->read({});
    ASSERT_NE(next, nullptr);
    EXPECT_EQ(next->tick.n, 257);
    EXPECT_TRUE(has(next->quality, Quality::gap));
}

TEST(WorldTest, PacedRunEqualsLockstepRun) {
    const Heard alone = play(quick(), 200);
    World world{quick(), World::Pace::paced};
    Rig rig = world.rig();
    std::vector<AccelBlock> blocks;
    std::vector<std::vector<Frame>> frames(2);
    std::vector<std::jthread> readers;
    constexpr std::chrono::milliseconds wait{20};
    readers.emplace_back([&] {
        AccelBlock b;
        while (!rig.accelerometer->ended())
            if (rig.accelerometer->read(b, wait)) blocks.push_back(b);
    });
    for (std::size_t c = 0; c < 2; ++c)
        readers.emplace_back([&, c] {
            while (!rig.cameras[c]->ended())
                if (FramePtr f = rig.cameras[c]->read(wait)) frames[c].push_back(*f);
        });
    const auto volts = test::volts_for(quick(), {});
    std::vector<double> trigger(block);
    for (long k = 0; k < 200; ++k) {
        const auto drive = test::samples(volts, 20, 48000, k * 240, block);
        for (std::size_t i = 0; i < block; ++i)
            trigger[i] = (k * 240 + static_cast<long>(i)) % 240 == 0 ? 1 : 0;
        rig.dac->write(drive, trigger);
    }
    rig.dac->stop();
    readers.clear();
    ASSERT_EQ(blocks.size(), alone.blocks.size());
    for (std::size_t i = 0; i < blocks.size(); ++i) EXPECT_EQ(blocks[i].counts, alone.blocks[i].counts);
    for (std::size_t c = 0; c < 2; ++c) {
        ASSERT_EQ(frames[c].size(), alone.frames[c].size());
        for (std::size_t i = 0; i < frames[c].size(); ++i)
            EXPECT_EQ(frames[c][i].pixels, alone.frames[c][i].pixels);
    }
}

// A reader that gets no processor time for a while is not late in virtual time.
TEST(WorldTest, PacedDacWaitsForReaderOfBlock) {
    World world{quick(), World::Pace::paced};
    Rig rig = world.rig();
    std::atomic<std::uint64_t> done{0};
    std::jthread reader{[&] {
        AccelBlock b;
        while (!rig.accelerometer->ended()) {
            if (!rig.accelerometer->read(b, std::chrono::milliseconds{20})) continue;
            std::this_thread::sleep_for(std::chrono::milliseconds{5});
            done += static_cast<std::uint64_t>(b.size);
        }
    }};
    const std::vector<double> zero(block);
    for (int k = 0; k < 40; ++k) {
        rig.dac->write(zero, zero);
        EXPECT_EQ(done, rig.accelerometer->counts().taken);
    }
    EXPECT_GT(done, 0U);
    rig.dac->stop();
}

/// Exposures of a walker whose motion within the period, and whose drift, change at 1.03 s.
std::vector<PoseTruth> corrected_in_the_middle(double rate_hz, double motion_change,
                                               double drift_change_mps) {
    std::vector<PoseTruth> poses;
    for (int i = 0; i / rate_hz < 3; ++i) {
        const double t = i / rate_hz, after = std::max(0.0, t - 1.03);
        const double motion = 1e-4 * (after > 0 ? 1 + motion_change : 1) * std::cos(2 * M_PI * 20 * t);
        poses.push_back({{i}, master_time(t), 0, 0.01 * t + drift_change_mps * after + motion});
    }
    return poses;
}

// Between two instants the change of the motion counts as drift: 0.1 um in 2 s, half an error of v_D.
TEST(DriftVelocityTest, MotionWithinThePeriodIsNoDrift) {
    for (const double rate : {1000.0, 997.0, 200.0})
        EXPECT_NEAR(drift_velocity(corrected_in_the_middle(rate, 0.01, 0), 0.53, 2.53, 20), 0.01, 2e-8)
            << rate;
}

// A line through all periods gives those in the middle more weight than the ends, as the fit of v_D does.
TEST(DriftVelocityTest, IsTheLineOfADriftThatChanges) {
    const double early = 0.25;  // share of the time before the change
    const double v = drift_velocity(corrected_in_the_middle(1000, 0, 1e-5), 0.53, 2.53, 20);
    EXPECT_NEAR(v - 0.01, 1e-5 * (1 - 3 * early * early + 2 * early * early * early), 2e-8);
}

TEST(DriftVelocityTest, IsUnknownOutsideTheExposures) {
    const auto poses = corrected_in_the_middle(1000, 0, 0);
    EXPECT_TRUE(std::isnan(drift_velocity(poses, 2, 4, 20)));
    EXPECT_TRUE(std::isnan(drift_velocity(poses, -1, 2, 20)));
    EXPECT_TRUE(std::isnan(drift_velocity({}, 0, 1, 20)));
}

}  // namespace
}  // namespace shaker::simulated

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <numbers>

#include "drivers/errors.hpp"
#include "drivers/simulated/world.hpp"
#include "tests/support/control/bench_drive.hpp"

namespace shaker::simulated {
namespace {

constexpr std::size_t block = 240;

struct Heard {
    std::map<std::int64_t, std::array<std::int32_t, 3>> samples;  // by tick
    std::vector<AccelBlock> blocks;
    std::vector<PlayTime> played;
    std::array<std::vector<Frame>, 2> frames;
    DeviceCounts dac, accelerometer;
    std::array<DeviceCounts, 2> cameras;
};

// One second of 1 g with 200 frames per second on the paper's bench with a fault. After lost time the caller
// continues at the tick reported by the DAC.
Heard play(const std::string& toml, double drive_g = 1) {
    Scene scene = parse_scene(toml, "test");
    for (CameraTruth& c : scene.cameras) c.view.frame_rate_hz = 200;
    World world{scene};
    Rig rig = world.rig();
    Heard h;
    const auto volts = test::volts_for(scene, {.gamma = 9.8 * drive_g});
    std::vector<double> trigger(block);
    for (std::int64_t n0 = 0; n0 < 48000;) {
        for (std::size_t i = 0; i < block; ++i)
            trigger[i] = (n0 + static_cast<std::int64_t>(i)) % 240 == 0 ? 1 : 0;
        h.played.push_back(rig.dac->write(test::samples(volts, 20, 48000, n0, block), trigger));
        n0 += static_cast<std::int64_t>(block) + h.played.back().lost;
        for (AccelBlock b; rig.accelerometer->read(b, {});) {
            h.blocks.push_back(b);
            for (int i = 0; i < b.size; ++i) h.samples[b.first.n + i] = b.counts[static_cast<std::size_t>(i)];
        }
        for (std::size_t c = 0; c < 2; ++c)
            while (FramePtr f = rig.cameras[c]->read({})) h.frames[c].push_back(*f);
    }
    h.dac = rig.dac->counts();
    h.accelerometer = rig.accelerometer->counts();
    for (std::size_t c = 0; c < 2; ++c) h.cameras[c] = rig.cameras[c]->counts();
    return h;
}

std::string fault(const std::string& what, double at_s, const std::string& rest = "") {
    return "[[fault]]\nwhat = \"" + what + "\"\nat_s = " + std::to_string(at_s) + "\n" + rest + "\n";
}

// First accelerometer tick at or after a time, by its clock in the paper's scene.
std::int64_t tick_at(double t) {
    return static_cast<std::int64_t>(std::ceil((t - 0.0031) * 4000 * (1 + 37.5e-6)));
}

const Heard& healthy() {
    static const Heard h = play("");
    return h;
}

// Before tick `from` and from tick `to` on, every sample equals that of the healthy bench.
void expect_healthy_outside(const Heard& h, std::int64_t from, std::int64_t to) {
    for (const auto& [tick, counts] : h.samples) {
        if (tick >= from && tick < to) continue;
        ASSERT_EQ(counts, healthy().samples.at(tick)) << "tick " << tick;
    }
    EXPECT_EQ(h.samples.count(from - 1), 1U);
}

TEST(FaultTest, AnAccelerometersFaultBeginsAndEndsAtItsSample) {
    const std::int64_t from = tick_at(0.5), to = tick_at(0.6);
    constexpr std::int32_t rail = (1 << 19) - 1;
    const auto of = [](const Heard& h, std::int64_t tick, std::size_t k) { return h.samples.at(tick)[k]; };
    const auto check = [&](const std::string& what, const std::string& rest, auto&& holds) {
        const Heard h = play(fault(what, 0.5, "for_s = 0.1\n" + rest));
        expect_healthy_outside(h, from, to);
        for (std::int64_t tick = from; tick < to; ++tick)
            for (std::size_t k = 0; k < 3; ++k)
                ASSERT_TRUE(holds(h, tick, k, of(healthy(), tick, k))) << what << ", tick " << tick;
    };
    const double lsb = 78.5 / (1 << 19);
    // Noise of 25 ug/rtHz: 0.011 m/s^2 rms a sample.
    check("open", "", [&](const Heard& h, std::int64_t t, std::size_t k, int) {
        return std::abs(of(h, t, k) * lsb) < 0.08;
    });
    check("frozen", "", [&](const Heard& h, std::int64_t t, std::size_t k, int) {
        return of(h, t, k) == of(healthy(), from - 1, k);
    });
    check("saturated", "",
          [&](const Heard& h, std::int64_t t, std::size_t k, int) { return std::abs(of(h, t, k)) == rail; });
    // The noise stays as it is: twice 5 sigma and a count.
    check("flipped", "", [&](const Heard& h, std::int64_t t, std::size_t k, int was) {
        return std::abs((of(h, t, k) + was) * lsb) < 0.12;
    });
    check("gain", "value = 1.3", [&](const Heard& h, std::int64_t t, std::size_t k, int was) {
        return std::abs((of(h, t, k) - 1.3 * was) * lsb) < 0.08;
    });
    check("swapped", "", [&](const Heard& h, std::int64_t t, std::size_t k, int) {
        return std::abs((of(h, t, k) - of(healthy(), t, (k + 1) % 3)) * lsb) < 0.12;
    });
}

TEST(FaultTest, ASaturatedBlockIsMarked) {
    const Heard h = play(fault("saturated", 0.5));
    for (const AccelBlock& b : h.blocks)
        EXPECT_EQ(has(b.quality, Quality::clipped), b.first.n + b.size > tick_at(0.5));
    const Heard strong = play("[accelerometer]\nrange_mps2 = 9.9\n", 3);
    EXPECT_TRUE(has(strong.blocks.back().quality, Quality::clipped));
    for (const auto& [tick, counts] : strong.samples) ASSERT_LE(std::abs(counts[0]), (1 << 19) - 1);
}

TEST(FaultTest, MissingSamplesLeaveAMarkedGapOfTheirNumber) {
    const std::int64_t from = tick_at(0.5);
    const auto check = [&](const Heard& h, std::int64_t lost) {
        expect_healthy_outside(h, from, 1L << 40);
        const auto late = tick_at(0.9);  // other noise, the same motion
        EXPECT_NEAR(h.samples.at(late)[0], healthy().samples.at(late)[0], 0.12 * (1 << 19) / 78.5);
        EXPECT_EQ(h.samples.lower_bound(from)->first, from + lost);
        for (const AccelBlock& b : h.blocks)
            EXPECT_EQ(has(b.quality, Quality::gap), b.first.n == from + lost);
        EXPECT_EQ(h.accelerometer.lost, static_cast<std::uint64_t>(lost));
    };
    check(play(fault("drop", 0.5, "value = 1")), 1);
    check(play(fault("drop", 0.5, "value = 1000")), 1000);
    check(play(fault("silent", 0.5, "for_s = 0.1")), tick_at(0.6) - from);
}

TEST(FaultTest, TheAmplifiersGainChangesWithItsSample) {
    const Heard h = play(fault("amplifier_gain", 0.5, "value = -1"));
    expect_healthy_outside(h, tick_at(0.5), 1L << 40);
    const auto late = h.samples.at(tick_at(0.51))[0], was = healthy().samples.at(tick_at(0.51))[0];
    EXPECT_GT(std::abs(late - was), 10000);
}

// Bright pixels of a disc on dark ground, in the lower part of the top picture.
long bright(const Frame& f) {
    long count = 0;
    for (std::size_t i = f.pixels.size() / 4; i < f.pixels.size(); ++i)
        count += std::to_integer<int>(f.pixels[i]) > 110 ? 1 : 0;
    return count;
}

TEST(FaultTest, WalkerTakenOffAndPutBackShows) {
    const Heard h = play(fault("walker_off", 0.5) + fault("walker_on", 0.7));
    expect_healthy_outside(h, tick_at(0.5), 1L << 40);
    EXPECT_NE(h.samples.at(tick_at(0.55)), healthy().samples.at(tick_at(0.55)));
    for (const Frame& f : h.frames[0]) {
        const bool off = f.tick.n >= 100 && f.tick.n < 140;
        EXPECT_EQ(bright(f) < 20, off) << f.tick.n;
    }
}

TEST(FaultTest, HiddenWalkerIsInvisible) {
    const Heard h = play(fault("walker_hidden", 0.5, "for_s = 0.1"));
    ASSERT_EQ(h.frames[0].size(), healthy().frames[0].size());
    for (const Frame& f : h.frames[0]) {
        const bool hidden = f.tick.n >= 100 && f.tick.n < 120;
        if (hidden)
            EXPECT_LT(bright(f), 20) << f.tick.n;
        else
            EXPECT_EQ(f.pixels, healthy().frames[0][static_cast<std::size_t>(f.tick.n)].pixels) << f.tick.n;
    }
    EXPECT_GT(bright(h.frames[0][10]), 1000);
    EXPECT_EQ(h.samples, healthy().samples);
}

TEST(FaultTest, LostFramesAffectTheirCameraOnly) {
    const Heard h = play(fault("camera_lose", 0.3, "camera = \"side\"") +
                         fault("camera_stall", 0.5, "for_s = 0.1\ncamera = \"top\""));
    const auto check = [](const std::vector<Frame>& frames, std::int64_t from, std::int64_t to) {
        std::int64_t next = 0;
        for (const Frame& f : frames) {
            if (next == from) next = to;
            EXPECT_EQ(f.tick.n, next++);
            EXPECT_EQ(has(f.quality, Quality::gap), f.tick.n == to);
        }
        EXPECT_GT(next, to);
    };
    check(h.frames[0], 100, 120);
    check(h.frames[1], 60, 61);
    EXPECT_EQ(h.cameras[0].lost, 20U);
    EXPECT_EQ(h.cameras[1].lost, 1U);
}

TEST(FaultTest, AnUnderrunSilencesTheBlockAndTheLostTime) {
    const Heard h = play(fault("underrun", 0.5, "value = 480"));
    std::size_t underruns = 0;
    for (std::size_t k = 0; k < h.played.size(); ++k) {
        const PlayTime& p = h.played[k];
        EXPECT_EQ(p.lost, p.tick.n == 24000 ? 480 : 0);
        underruns += p.lost > 0 ? 1 : 0;
        if (k == 0) continue;
        EXPECT_EQ(p.tick.n, h.played[k - 1].tick.n + 240 + h.played[k - 1].lost);
        // Ticks keep their place in time.
        EXPECT_EQ((p.heard - h.played[0].heard).count(),
                  std::llround(static_cast<double>(p.tick.n) * (1e9 / 48000)));
    }
    EXPECT_EQ(underruns, 1U);
    EXPECT_EQ(h.dac.lost, 480U);
    EXPECT_EQ(h.dac.incidents, 1U);
    expect_healthy_outside(h, tick_at(0.5), 1L << 40);
    EXPECT_NE(h.samples.at(tick_at(0.51)), healthy().samples.at(tick_at(0.51)));
}

TEST(FaultTest, BufferDelaysOutputByItsLength) {
    const Heard h = play("[dac]\nbuffer_s = 0.25\n");
    EXPECT_EQ(h.played[0].tick.n, 0);
    EXPECT_EQ((h.played[0].heard - healthy().played[0].heard).count(), 0);
    // The first sample is heard 12000 samples after it was written, at master time 0; the accelerometer is on
    // from the first write and hears the same motion 1000 of its ticks later.
    const auto moved = [](const Heard& x) {
        for (const auto& [tick, counts] : x.samples)
            if (std::abs(counts[0]) > 5000) return tick;
        return std::int64_t{-1};
    };
    EXPECT_NEAR(static_cast<double>(moved(h) - moved(healthy())), 1000, 1);
    EXPECT_LT(h.blocks.front().arrived, h.played[0].heard);
    EXPECT_EQ(seconds(*h.frames[0].front().mid_exposure), 150e-6);
    EXPECT_EQ(h.frames[0].front().tick.n, 0);
    EXPECT_EQ(h.frames[0][20].tick.n, 20);
}

TEST(FaultTest, BlocksHaveSceneLengthAndLastSamplesArrival) {
    const std::string eights = "[accelerometer]\nblock_samples = 8\nlatency_jitter_s = 0.0\n";
    const Heard h = play(eights + fault("drop", 0.5, "value = 3"));
    std::size_t shorter = 0;
    for (const AccelBlock& b : h.blocks) {
        shorter += b.size < 8 ? 1 : 0;
        const auto last = static_cast<double>(b.first.n + b.size - 1);
        const double latency = std::chrono::duration<double>(b.arrived - healthy().played[0].heard).count() -
                               0.0031 - last / (4000 * (1 + 37.5e-6));
        EXPECT_NEAR(latency, 0.0008, 1e-8);
    }
    EXPECT_LE(shorter, 1U);
    EXPECT_GT(h.blocks.size(), 7 * healthy().blocks.size());
}

TEST(FaultTest, HumIsOnAllAxes) {
    const Heard h = play("[accelerometer]\nmains_hz = 50.0\nmains_mps2 = 0.5\n", 0);
    for (std::size_t k = 0; k < 3; ++k) {
        std::complex<double> sum = 0;
        double mean = 0;
        for (std::int64_t t = 0; t < 3200; ++t) mean += h.samples.at(t)[k] / 3200.0;
        for (std::int64_t t = 0; t < 3200; ++t)
            sum += (h.samples.at(t)[k] - mean) *
                   std::polar(2.0 / 3200, -two_pi * 50 * static_cast<double>(t) / 4000);
        EXPECT_NEAR(std::abs(sum) * 78.5 / (1 << 19), 0.5, 0.002);  // noise: 0.011 / sqrt(1600)
    }
}

TEST(FaultTest, TheSameSceneGivesTheSameBytes) {
    const std::string toml = fault("drop", 0.3, "value = 100") + fault("underrun", 0.4, "value = 480") +
                             fault("walker_off", 0.5) + fault("open", 0.6, "for_s = 0.1");
    const Heard a = play(toml), b = play(toml);
    EXPECT_EQ(a.samples, b.samples);
    ASSERT_EQ(a.frames[1].size(), b.frames[1].size());
    for (std::size_t i = 0; i < a.frames[1].size(); ++i)
        EXPECT_EQ(a.frames[1][i].pixels, b.frames[1][i].pixels);
}

TEST(FaultTest, FaultsAreReadStrictlyAndReadBack) {
    const std::string toml = fault("gain", 0.25, "value = 1.3\nfor_s = 2.0") +
                             fault("camera_stall", 1, "for_s = 0.5\ncamera = \"top\"") +
                             fault("walker_off", 3);
    const Scene scene = parse_scene(toml, "x");
    ASSERT_EQ(scene.faults.size(), 3U);
    EXPECT_EQ(scene.faults[0].value, 1.3);
    EXPECT_EQ(scene.faults[1].camera, "top");
    EXPECT_EQ(scene_text(parse_scene(scene_text(scene), "x")), scene_text(scene));
    const auto refused = [](const std::string& text, const std::string& about) {
        try {
            parse_scene(text, "x");
        } catch (const InputError& e) {
            return std::string{e.what()}.find(about) != std::string::npos;
        }
        return false;
    };
    EXPECT_TRUE(refused(fault("unplugged", 1), "unplugged"));
    EXPECT_TRUE(refused(fault("silent", 1), "for_s"));
    EXPECT_TRUE(refused(fault("drop", 1), "value"));
    EXPECT_TRUE(refused(fault("open", 1, "value = 2"), "value"));
    EXPECT_TRUE(refused(fault("camera_lose", 1, "camera = \"left\""), "left"));
    EXPECT_TRUE(refused("[[fault]]\nwhat = \"open\"\n", "at_s"));
}

TEST(FaultTest, BadSampleChangesOneSample) {
    const Heard plain = play(""), h = play(fault("bad_sample", 0.5, "value = 50"));
    ASSERT_EQ(h.samples.size(), plain.samples.size());
    int changed = 0;
    for (const auto& [tick, counts] : h.samples) {
        if (counts == plain.samples.at(tick)) continue;
        ++changed;
        EXPECT_EQ(tick, tick_at(0.5));
        EXPECT_NEAR(counts[0] * 78.5 / (1 << 19), 50, 1e-3);
    }
    EXPECT_EQ(changed, 1);
}

TEST(FaultTest, FrozenAxisRepeatsItsValueAlone) {
    const Heard plain = play(""), h = play(fault("frozen_axis", 0.4, "for_s = 0.04"));
    for (const auto& [tick, counts] : h.samples) {
        const bool frozen = tick >= tick_at(0.4) && tick < tick_at(0.44);
        EXPECT_EQ(counts[0], (frozen ? h : plain).samples.at(frozen ? tick_at(0.4) - 1 : tick)[0]);
        EXPECT_EQ(counts[1], plain.samples.at(tick)[1]);
    }
}

TEST(FaultTest, FastClockTakesSamplesEarly) {
    const Heard plain = play(""), h = play("[accelerometer]\nclock_drift_ppm_per_min = 100\n");
    int largest = 0;
    for (const auto& [tick, counts] : h.samples)
        if (plain.samples.contains(tick))
            largest = std::max(largest, std::abs(counts[0] - plain.samples.at(tick)[0]));
    // 0.8 us after 1 s, at up to 1800 m/s^3; one step of the sensor is 0.15 mm/s^2.
    EXPECT_GE(largest, 3);
    EXPECT_LE(largest, 20);
    EXPECT_EQ(scene_text(parse_scene("", "test")).find("clock_drift"), std::string::npos);
}

}  // namespace
}  // namespace shaker::simulated

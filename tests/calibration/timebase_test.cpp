#include "calibration/clocks/timebase.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "drivers/trigger_train.hpp"

namespace shaker::calibration {
namespace {

constexpr double dac_hz = 48000, accelerometer_hz = 4000, fps = 200;
constexpr double dac_ppm = 30, accelerometer_ppm = -45, free_ppm = 120;
constexpr std::int64_t dac_block = 256, block_size = 16;

HostTime host(double s) { return HostTime{std::chrono::nanoseconds{std::llround(1e9 * (4000 + s))}}; }

View view(const char* name, bool triggered) {
    return {.camera = name,
            .frame_rate_hz = fps,
            .exposure_s = 4e-4,
            .dac_triggered = triggered,
            .trigger_delay_s = 5e-6,
            .arrival_delay_s = 3e-3,
            .targets = {}};
}

TimebaseDevices devices() {
    return {.dac_rate_hz = dac_hz,
            .accelerometer_rate_hz = accelerometer_hz,
            .first_sample_s = 0,
            .cameras = {view("triggered", true), view("free", false)}};
}

// Devices with known rates in true time. Stamps are late by 20 us on average. Camera 0 exposes on the DAC's
// pulses, camera 1 by its own clock.
struct Bench {
    std::mt19937_64 rng{3};
    std::exponential_distribution<double> late{5e4};
    std::vector<PlayTime> played;
    std::vector<AccelBlock> blocks;
    std::array<std::vector<FrameStamp>, 2> frames;

    explicit Bench(double until_s, double sensor_ppm = accelerometer_ppm) {
        for (std::int64_t n = 0; true_time_of_sample(n) < until_s; n += dac_block)
            played.push_back({{n}, host(true_time_of_sample(n) + late(rng)), 0});
        const double rate = accelerometer_hz * (1 + 1e-6 * sensor_ppm);
        for (std::int64_t n = 0; static_cast<double>(n) / rate < until_s; n += block_size) {
            AccelBlock b;
            b.first = {n};
            b.size = block_size;
            b.arrived = host(static_cast<double>(n + block_size - 1) / rate + late(rng));
            blocks.push_back(b);
        }
        for (std::int64_t k = 0; static_cast<double>(k) < fps * until_s; ++k) {
            const double pulse_s = true_time_of_sample(TriggerTrain::pulse(k, dac_hz, fps));
            frames[0].push_back({{k}, {}, host(pulse_s + 3e-3 + late(rng))});
            const double free_s = static_cast<double>(k) / (fps * (1 + 1e-6 * free_ppm));
            frames[1].push_back({{k}, {}, host(free_s + 3e-3 + late(rng))});
        }
    }
    static double true_time_of_sample(std::int64_t n) {
        return static_cast<double>(n) / (dac_hz * (1 + 1e-6 * dac_ppm));
    }
    void give_all(Timebase& t) const {
        for (const PlayTime& p : played) t.add(p);
        for (const AccelBlock& b : blocks) t.add(b);
        for (std::size_t c = 0; c < frames.size(); ++c)
            for (const FrameStamp& f : frames[c]) t.add(c, f);
    }
};

TEST(TimebaseTest, PutsEveryDeviceOnMasterTime) {
    const Bench bench{12};
    Timebase timebase{devices()};
    bench.give_all(timebase);
    ASSERT_TRUE(timebase.ready());
    // Master time is the DAC's count at its nominal rate, so it runs 30 ppm fast against the true time.
    const double rate = 1 + 1e-6 * dac_ppm;
    const double true_s = 40000 / (accelerometer_hz * (1 + 1e-6 * accelerometer_ppm));
    EXPECT_NEAR(seconds(timebase.at(AccelTick{40000})), rate * true_s, 5e-6);
    EXPECT_EQ(seconds(timebase.at(DacTick{96000})), 2);
    ASSERT_TRUE(timebase.heard(DacTick{96000}));
    EXPECT_NEAR(1e-9 * static_cast<double>((*timebase.heard(DacTick{96000}) - host(2 / rate)).count()), 0,
                5e-6);
    const FrameStamp& triggered = bench.frames[0][1000];
    const auto pulse = TriggerTrain::pulse(1000, dac_hz, fps);
    EXPECT_NEAR(seconds(timebase.mid_exposure(0, 1000, triggered)),
                static_cast<double>(pulse) / dac_hz + 5e-6 + 2e-4, 1e-12);
    const double free_s = 1000 / (fps * (1 + 1e-6 * free_ppm));
    EXPECT_NEAR(seconds(timebase.mid_exposure(1, 1000, bench.frames[1][1000])), rate * free_s + 2e-4, 5e-6);
}

// Drive and sensor on one card: the stamps leave one constant, and no rate.
TEST(TimebaseTest, ASensorWithTheClockOfTheDacHasItsRateExactly) {
    const Bench bench{12, dac_ppm};
    TimebaseDevices one_card = devices();
    one_card.dac_clock = true;
    Timebase timebase{one_card};
    bench.give_all(timebase);
    const double delay_s = seconds(timebase.at(AccelTick{0}));
    EXPECT_NEAR(delay_s, 0, 2e-6);  // tick 0 is at sample 0
    for (const std::int64_t n : {4000, 40000, 48000})
        EXPECT_NEAR(seconds(timebase.at(AccelTick{n})), delay_s + static_cast<double>(n) / accelerometer_hz,
                    1e-12);
}

TEST(TimebaseTest, EveryClockHasAFitWithItsError) {
    const Bench bench{12};
    Timebase timebase{devices()};
    bench.give_all(timebase);
    const auto expect = [](const ClockFit& fit, double ppm, std::size_t stamps) {
        EXPECT_NEAR(fit.ppm, ppm, 3 * fit.ppm_sigma);
        EXPECT_LT(fit.ppm_sigma, 2);
        EXPECT_NEAR(fit.delay.count(), 20e-6, 5e-6);
        EXPECT_EQ(fit.stamps, stamps);
        EXPECT_EQ(fit.jumps, 0U);
    };
    expect(timebase.dac(), dac_ppm, bench.played.size());
    expect(timebase.accelerometer(), accelerometer_ppm, bench.blocks.size());
    expect(timebase.camera(0), dac_ppm, bench.frames[0].size());  // its exposures are the DAC's pulses
    expect(timebase.camera(1), free_ppm, bench.frames[1].size());
    EXPECT_FALSE(timebase.camera_stamps(0));
}

// A recording is read device by device; a live bench mixes the devices.
TEST(TimebaseTest, OrderBetweenDevicesDoesNotMatter) {
    const Bench bench{3};
    Timebase live{devices()}, replayed{devices()};
    std::array<std::size_t, 2> number{};
    std::size_t block = 0;
    for (std::size_t k = 0; k < bench.played.size(); ++k) {
        live.add(bench.played[k]);
        for (; block < bench.blocks.size() && bench.blocks[block].arrived <= bench.played[k].heard; ++block)
            live.add(bench.blocks[block]);
        for (std::size_t c = 0; c < 2; ++c)
            for (; number[c] < bench.frames[c].size() &&
                   bench.frames[c][number[c]].arrived <= bench.played[k].heard;
                 ++number[c]) {
                live.add(c, bench.frames[c][number[c]]);
                (void)live.mid_exposure(c, number[c], bench.frames[c][number[c]]);
            }
    }
    for (; block < bench.blocks.size(); ++block) live.add(bench.blocks[block]);
    for (std::size_t c = 0; c < 2; ++c)
        for (; number[c] < bench.frames[c].size(); ++number[c]) live.add(c, bench.frames[c][number[c]]);
    bench.give_all(replayed);
    live.settle();
    for (std::int64_t tick = 0; tick < 12000; tick += 97)
        ASSERT_EQ(live.at(AccelTick{tick}), replayed.at(AccelTick{tick})) << tick;
    for (std::size_t c = 0; c < 2; ++c)
        for (std::size_t k = 0; k < bench.frames[c].size(); ++k)
            ASSERT_EQ(live.mid_exposure(c, k, bench.frames[c][k]),
                      replayed.mid_exposure(c, k, bench.frames[c][k]))
                << c << " " << k;
}

TEST(TimebaseTest, UnderrunCountsAsJumpAndKeepsRate) {
    const Bench bench{6};
    Timebase timebase{devices()};
    bench.give_all(timebase);
    const double before = timebase.dac().ppm;
    const std::int64_t end = bench.played.back().tick.n;
    timebase.add(PlayTime{{end}, bench.played.back().heard, 480});
    EXPECT_FALSE(timebase.ready());
    EXPECT_TRUE(std::isnan(seconds(timebase.at(AccelTick{0}))));
    EXPECT_TRUE(std::isnan(timebase.dac().delay.count()));
    timebase.add(PlayTime{{end + dac_block}, bench.played.back().heard + std::chrono::milliseconds{50}, 0});
    EXPECT_TRUE(timebase.ready());
    EXPECT_EQ(timebase.dac().jumps, 1U);
    EXPECT_EQ(timebase.dac().ppm, before);
}

TEST(TimebaseTest, WithoutADacTheAccelerometerCounts) {
    Timebase timebase{{.accelerometer_rate_hz = 1000, .first_sample_s = 0.25, .cameras = {}}};
    EXPECT_EQ(seconds(timebase.at(AccelTick{500})), 0.75);
}

TEST(TimebaseTest, FramesWithOwnTimeAffectOnlyTheRate) {
    const Bench bench{5};
    Timebase timebase{devices()};
    for (const FrameStamp& f : bench.frames[1]) timebase.add(1, f, Timebase::FrameTime::frame);
    EXPECT_EQ(timebase.frames(1), 0U);
    EXPECT_EQ(timebase.camera(1).stamps, bench.frames[1].size());
    EXPECT_NEAR(timebase.camera(1).ppm, free_ppm, 3 * timebase.camera(1).ppm_sigma);
}

TEST(TimebaseTest, ACameraOfUnknownRateHasNoPpm) {
    TimebaseDevices d = devices();
    d.cameras[1].frame_rate_hz = 0;
    Timebase timebase{d};
    const Bench bench{3};
    for (const FrameStamp& f : bench.frames[1]) timebase.add(1, f);
    EXPECT_TRUE(std::isnan(timebase.camera(1).ppm));
    EXPECT_TRUE(std::isnan(timebase.camera(1).ppm_sigma));
}

}  // namespace
}  // namespace shaker::calibration

// The guard on the complete simulated bench with walker and clocks. The expectation comes from measured
// harmonics, as in a controller.
#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <functional>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

#include "calibration/clocks/timebase.hpp"
#include "daemon/acquisition/drive_output.hpp"
#include "daemon/acquisition/steps.hpp"
#include "drivers/simulated/shaker_plant.hpp"
#include "drivers/simulated/world.hpp"

namespace shaker::safety {
namespace {

constexpr double f = 20;
constexpr std::int64_t block = 240;

/// An accelerometer whose samples a test can change.
class Bent final : public Accelerometer {
public:
    explicit Bent(Accelerometer& inner) : inner_{inner} {}
    [[nodiscard]] AccelerometerInfo info() const override { return inner_.info(); }
    bool read(AccelBlock& out, std::chrono::milliseconds wait) override {
        if (!inner_.read(out, wait)) return false;
        for (auto& counts : out.counts)
            if (bend) bend(counts);
        return true;
    }
    [[nodiscard]] bool ended() const noexcept override { return inner_.ended(); }
    void stop() noexcept override { inner_.stop(); }
    std::function<void(std::array<std::int32_t, 3>&)> bend;

private:
    Accelerometer& inner_;
};

class SimulatedBench {
public:
    SimulatedBench()
        : output{rig.dac->info(), f, 0, block, limits(), rig.accelerometer->info().rate_hz},
          input{SampleGuard{rig.accelerometer->info(), rig.dac->info().rate_hz, limits()}} {}

    void go(double s) {
        const double rate = rig.dac->info().rate_hz;
        for (const auto end = output.synthesiser.tick().n + std::llround(s * rate);
             output.synthesiser.tick().n < end;) {
            output_step(output, *rig.dac, channels);
            while (accelerometer_step(input, sensor, {}, channels)) {
            }
            while (const auto p = channels.played.pop()) clock.add(*p);
            channels.gathered = output.synthesiser.tick().n;
            while (const auto b = channels.blocks.pop()) {
                clock.add(*b);
                blocks.push_back(*b);
            }
            while (const auto t = channels.trips.pop()) trips.push_back(*t);
        }
    }
    void drive(const Drive& d, int ramp_periods) {
        DriveCommand c{.volts = {}, .frequency = f, .ramp_periods = ramp_periods};
        const Harmonics<Acceleration> a = harmonics(d);
        for (int q = 1; q <= 2; ++q) {
            const auto h = simulated::ShakerPlant::response(scene, q * f);
            c.volts.at(q) = a.at(q) / std::complex<double>{h[0], h[1]};
        }
        volts = c.volts;
        channels.drive.post(c);
    }
    /// Expectation from the last second: 20 periods of the motion by the present drive.
    [[nodiscard]] Expectation measured() const {
        const AccelerometerInfo info = rig.accelerometer->info();
        const double dac_rate = rig.dac->info().rate_hz,
                     yaw = scene.accelerometer.yaw_deg * std::numbers::pi / 180;
        Expectation e{.frequency = f, .axis = {std::cos(yaw), -std::sin(yaw), 0}, .sigma = 0.011};
        Harmonics<Acceleration> sum;
        int n = 0;
        for (std::size_t i = blocks.size() - 63; i < blocks.size(); ++i)
            for (int k = 0; k < blocks[i].size && n < 4000; ++k, ++n) {
                const auto a = info.acceleration(blocks[i].counts[static_cast<std::size_t>(k)]);
                const double along = e.axis[0] * a[0] + e.axis[1] * a[1];
                const double turns = f * seconds(clock.at(AccelTick{blocks[i].first.n + k}));
                for (int q = 1; q <= 2; ++q)
                    sum.at(q) += along * std::complex<double>{std::sin(q * two_pi * turns),
                                                              std::cos(q * two_pi * turns)};
            }
        for (int q = 1; q <= 2; ++q)
            e.response[static_cast<std::size_t>(q - 1)] = 2.0 / n * sum.at(q) / volts.at(q);
        e.at = blocks.back().first;
        const double now_s = seconds(clock.at(e.at)), before_s = seconds(clock.at(AccelTick{e.at.n - 4000}));
        e.dac_sample = dac_rate * now_s;
        e.dac_per_tick = dac_rate * (now_s - before_s) / 4000;
        return e;
    }
    /// A B&K 4809 and an ADXL355 at 8 g.
    static Limits limits() {
        return limits_of({.max_force_n = 45,
                          .moving_mass_kg = 0.057,
                          .load_kg = 0.56,
                          .stroke_m = 8e-3,
                          .max_velocity_mps = 1.65,
                          .sensor_range_mps2 = 78.5,
                          .full_scale_V = 1});
    }

    simulated::Scene scene = simulated::paper_scene();
    simulated::World world{scene, simulated::World::Pace::lockstep};
    Rig rig = world.rig();
    Bent sensor{*rig.accelerometer};
    acquisition::Channels channels{0};
    acquisition::DriveOutput output;
    acquisition::AccelerometerInput input;
    calibration::Timebase clock{{.dac_rate_hz = rig.dac->info().rate_hz,
                                 .accelerometer_rate_hz = rig.accelerometer->info().rate_hz,
                                 .cameras = {}}};
    Harmonics<Voltage> volts;
    std::vector<AccelBlock> blocks;
    std::vector<Trip> trips;
};

TEST(GuardBenchTest, TripsForFlippedSensorButNotForSetPoints) {
    SimulatedBench bench;
    bench.go(1);
    bench.drive({.gamma = paper_g}, 10);
    bench.go(2.5);
    bench.channels.expectation.post(bench.measured());
    bench.go(0.5);
    std::mt19937_64 rng{9};
    std::uniform_real_distribution<double> unit{0, 1};
    for (int i = 0; i < 20; ++i) {
        bench.drive({.gamma = (0.5 + unit(rng)) * paper_g, .rho = unit(rng), .phi = two_pi * unit(rng)},
                    1 + i % 3);
        bench.go(1);
    }
    bench.drive({.gamma = paper_g}, 1);
    bench.go(1);
    for (const Trip& t : bench.trips) ADD_FAILURE() << text(t);
    EXPECT_EQ(bench.output.synthesiser.clamped(), 0U);
    const std::int64_t flipped = bench.blocks.back().first.n + AccelBlock::capacity;
    bench.sensor.bend = [](auto& c) { c = {-c[0], -c[1], c[2]}; };
    bench.go(0.2);
    ASSERT_FALSE(bench.trips.empty());
    EXPECT_TRUE(bench.trips[0].cause == Cause::polarity || bench.trips[0].cause == Cause::residual)
        << text(bench.trips[0]);
    EXPECT_TRUE(bench.trips[0].on_dac_clock);
    const std::int64_t tripped = bench.trips[0].tick / 12;
    EXPECT_LE(tripped - flipped, 80) << "accelerometer samples";
    EXPECT_TRUE(bench.channels.stopped);
    EXPECT_TRUE(bench.output.synthesiser.silent());
}

}  // namespace
}  // namespace shaker::safety

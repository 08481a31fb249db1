#pragma once
// A small bench for the sample guard, fast enough for millions of samples: the real synthesiser, a shaker
// with one resonance, and a sensor with noise, gravity and its own clock.
#include <array>
#include <cmath>
#include <complex>
#include <cstdint>
#include <functional>
#include <optional>
#include <random>
#include <vector>

#include "daemon/safety/sample_guard.hpp"
#include "drivers/synthesiser.hpp"

namespace shaker::test {

struct GuardBenchSettings {
    double dac_rate_hz = 8000;
    double rate_hz = 4000;  // of the accelerometer
    double clock_ppm = 37;
    double resonance_hz = 15;
    double q = 3;
    double gain = 40;           // m/s^2 per V far above the resonance
    double noise_mps2 = 0.011;  // rms of a sample
    double lsb_mps2 = 150e-6;
    double range_mps2 = 78.5;
    double start_frequency = 20;
    std::array<double, 3> axis{0.8, 0.6, 0};
    std::uint64_t seed = 1;
};

/// Limits of that bench: 60 m/s^2, 0.5 m/s, 4 mm, 1 V.
safety::Limits bench_limits();

class GuardBench {
public:
    using Counts = std::array<std::int32_t, 3>;
    GuardBench(const GuardBenchSettings& settings, const std::optional<safety::Limits>& limits);

    /// Runs for s seconds.
    void run(double s);
    /// Harmonics of the base (m/s^2 along the axis) as a command in volts.
    [[nodiscard]] DriveCommand command(const Drive& drive, int ramp_periods = 1) const;
    /// The expectation that a perfect identification at this frequency would post.
    [[nodiscard]] safety::Expectation expectation(double frequency) const;
    [[nodiscard]] double now_s() const { return static_cast<double>(synth.tick().n) / p_.dac_rate_hz; }
    /// Time of a trip, s.
    [[nodiscard]] double seconds_of(const safety::Trip& trip) const {
        return static_cast<double>(trip.tick) / (trip.on_dac_clock ? p_.dac_rate_hz : p_.rate_hz);
    }

    Synthesiser synth;
    safety::SampleGuard guard;
    safety::Warnings warnings;
    std::vector<safety::Trip> trips;
    std::int64_t samples = 0;  // of the accelerometer, judged
    /// Changes of the truth: additional motion of the base (time in s; m/s^2), a factor on the motion by the
    /// drive, and a change of each sample (time, counts); it returns false for a missing sample.
    std::function<double(double)> disturbance;
    double plant_gain = 1;
    std::function<bool(double, Counts&)> sensor;

private:
    [[nodiscard]] std::complex<double> response(double frequency) const;
    void convert(double t_s, double a);

    GuardBenchSettings p_;
    std::array<double, 5> biquad_{};
    std::array<double, 2> memory_{};
    double before_ = 0;
    std::int64_t next_ = 0;  // tick of the next conversion
    AccelBlock block_{};
    std::mt19937_64 rng_;
    std::normal_distribution<double> normal_;
    Ring<safety::Trip> ring_{8};
};

}  // namespace shaker::test

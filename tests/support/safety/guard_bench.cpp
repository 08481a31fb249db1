#include "tests/support/safety/guard_bench.hpp"

namespace shaker::test {

namespace {
constexpr double start_s = 0.0017;  // of the sensor's tick 0
constexpr double bench_gravity = 9.8;
constexpr std::size_t guarded_block = 40;
}  // namespace

safety::Limits bench_limits() {
    safety::Limits l;
    l.acceleration = {48, 60};
    l.velocity = {0.4, 0.5};
    l.displacement = {3.2e-3, 4e-3};
    l.drive = {0.8, 1};
    l.sensor_range_mps2 = 78.5;
    return l;
}

GuardBench::GuardBench(const GuardBenchSettings& settings, const std::optional<safety::Limits>& limits)
    : synth{settings.dac_rate_hz, settings.start_frequency, 1},
      guard{{.name = "bench",
             .rate_hz = settings.rate_hz,
             .mps2_per_count = {settings.lsb_mps2, settings.lsb_mps2, settings.lsb_mps2},
             .shaker_axis = settings.axis},
            settings.dac_rate_hz,
            limits,
            settings.start_frequency},
      p_{settings},
      rng_{settings.seed},
      normal_{0, settings.noise_mps2} {
    // s^2 / (s^2 + s w0 / Q + w0^2) by the bilinear transform, its resonance prewarped.
    const double k = std::tan(std::numbers::pi * p_.resonance_hz / p_.dac_rate_hz);
    const double norm = 1 / (1 + k / p_.q + k * k);
    biquad_ = {norm, -2 * norm, norm, 2 * (k * k - 1) * norm, (1 - k / p_.q + k * k) * norm};
    block_.size = 0;
}

std::complex<double> GuardBench::response(double frequency) const {
    const auto z = std::polar(1.0, -two_pi * frequency / p_.dac_rate_hz);
    return p_.gain * (biquad_[0] + z * (biquad_[1] + z * biquad_[2])) /
           (1.0 + z * (biquad_[3] + z * biquad_[4]));
}

DriveCommand GuardBench::command(const Drive& drive, int ramp_periods) const {
    DriveCommand c{.volts = {}, .frequency = drive.frequency, .ramp_periods = ramp_periods};
    const Harmonics<Acceleration> a = harmonics(drive);
    for (int q = 1; q <= 2; ++q) c.volts.at(q) = a.at(q) / response(q * drive.frequency);
    return c;
}

safety::Expectation GuardBench::expectation(double frequency) const {
    safety::Expectation e{.frequency = frequency,
                          .axis = p_.axis,
                          .at = {0},
                          .dac_sample = start_s * p_.dac_rate_hz,
                          .dac_per_tick = p_.dac_rate_hz / (p_.rate_hz * (1 + 1e-6 * p_.clock_ppm)),
                          .sigma = p_.noise_mps2,
                          .settling_s = p_.q / (std::numbers::pi * p_.resonance_hz)};
    for (std::size_t k = 0; k < max_harmonics; ++k)
        e.response[k] = response(static_cast<double>(k + 1) * frequency);
    return e;
}

void GuardBench::convert(double t_s, double a) {
    if (disturbance) a += disturbance(t_s);
    const std::array<double, 3> truth{a * p_.axis[0], a * p_.axis[1], a * p_.axis[2] + bench_gravity};
    const double top = std::floor(p_.range_mps2 / p_.lsb_mps2);
    Counts counts;
    for (std::size_t k = 0; k < 3; ++k) {
        const double c = std::round((truth[k] + normal_(rng_)) / p_.lsb_mps2);
        if (std::abs(c) > top) block_.quality = block_.quality | Quality::clipped;
        counts[k] = static_cast<std::int32_t>(std::clamp(c, -top, top));
    }
    const bool there = !sensor || sensor(t_s, counts);
    if (there) {
        if (block_.size == 0) block_.first = {next_};
        block_.counts[static_cast<std::size_t>(block_.size++)] = counts;
    }
    ++next_;
    if (block_.size < AccelBlock::capacity && (there || block_.size == 0)) return;
    guard.check(block_, ring_, warnings);
    samples += block_.size;
    block_.size = 0;
    block_.quality = Quality::good;
    while (const auto trip = ring_.pop()) trips.push_back(*trip);
}

void GuardBench::run(double s) {
    std::array<double, guarded_block> volts;
    const std::int64_t end = synth.tick().n + std::llround(s * p_.dac_rate_hz);
    while (synth.tick().n < end) {
        std::int64_t n = synth.tick().n;
        synth.fill(volts);
        if (synth.change() != nullptr) guard.hear(*synth.change());
        for (const double v : volts) {
            const double in = plant_gain * p_.gain * v;
            const double out = biquad_[0] * in + memory_[0];
            memory_[0] = biquad_[1] * in - biquad_[3] * out + memory_[1];
            memory_[1] = biquad_[2] * in - biquad_[4] * out;
            // A conversion between the sample before and this one.
            for (;;) {
                const double t =
                    start_s + static_cast<double>(next_) / (p_.rate_hz * (1 + 1e-6 * p_.clock_ppm));
                const double at = t * p_.dac_rate_hz - static_cast<double>(n - 1);
                if (at > 1) break;
                convert(t, before_ + at * (out - before_));
            }
            before_ = out;
            ++n;
        }
    }
}

}  // namespace shaker::test

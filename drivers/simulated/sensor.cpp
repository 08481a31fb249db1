#include "drivers/simulated/sensor.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numbers>
#include <sstream>
#include <utility>

#include "drivers/attitude.hpp"
#include "drivers/time.hpp"

namespace shaker::simulated {

namespace {

using Vector = std::array<double, 3>;

Vector cross(const Vector& a, const Vector& b) noexcept {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

Vector scaled_to(double length, Vector a) noexcept {
    const double by = length / std::hypot(a[0], a[1], a[2]);
    for (double& x : a) x *= by;
    return a;
}

using std::numbers::pi;
constexpr double boot_s = 100;  // host time at DAC sample 0

}  // namespace

std::vector<std::string> words_of(const std::string& text) {
    std::istringstream in{text};
    return {std::istream_iterator<std::string>{in}, {}};
}

TurnedSensor::TurnedSensor(const Scene& scene)
    : hold_s_{scene.accelerometer.hold_s},
      turn_s_{scene.accelerometer.turn_s},
      gravity_{scene.gravity},
      up_{{0, 0, 1}} {
    std::mt19937_64 random{scene.seed * 2654435761U + 131};
    std::normal_distribution<double> angle{
        0, std::max(scene.accelerometer.held_within_deg, 1e-12) * std::numbers::pi / 180};
    for (const std::string& name : words_of(scene.accelerometer.attitudes)) {
        Vector up = *direction_of(name);
        const double x = angle(random), y = angle(random), z = angle(random);
        const Vector by = cross({x, y, z}, up);
        for (std::size_t k = 0; k < 3; ++k) up[k] += by[k];
        up_.push_back(scaled_to(1, up));
    }
}

Vector TurnedSensor::force(double t) const noexcept {
    const double turns = std::max(t - hold_s_, 0.0) / (turn_s_ + hold_s_);
    const auto last = std::min(static_cast<std::size_t>(turns), up_.size() - 1);
    const auto next = std::min(last + 1, up_.size() - 1);
    const double s = std::min((turns - static_cast<double>(last)) * (turn_s_ + hold_s_) / turn_s_, 1.0);
    // From one direction to the next by the side, so that opposite ones have a way too.
    const Vector &a = up_[last], &b = up_[next], aside = cross(a, {0.48, 0.6, 0.64});
    Vector up{};
    for (std::size_t k = 0; k < 3; ++k)
        up[k] = (1 - s) * a[k] + s * b[k] + s * (1 - s) * aside[k] * (last == next ? 0 : 1);
    return scaled_to(gravity_, up);
}

HostTime host_time(double true_s) noexcept {
    return HostTime{std::chrono::nanoseconds{std::llround((boot_s + true_s) * 1e9)}};
}

AccelerometerModel::AccelerometerModel(const Scene& scene)
    : p_{scene.accelerometer},
      dac_rate_{scene.dac_rate_hz},
      gravity_{scene.gravity * std::cos(scene.tilt_deg * pi / 180)},
      downhill_{scene.gravity * std::sin(scene.tilt_deg * pi / 180)},
      turned_{scene},
      lsb_{p_.range_mps2 / std::ldexp(1.0, p_.bits - 1)},
      axis_{std::cos(p_.yaw_deg * pi / 180), -std::sin(p_.yaw_deg * pi / 180), 0},
      high_pass_keep_{(1 - std::tan(pi * p_.high_pass_hz / dac_rate_)) /
                      (1 + std::tan(pi * p_.high_pass_hz / dac_rate_))},
      start_s_{p_.start_s - scene.dac_buffer_s},
      faults_{scene.faults,
              {FaultKind::open, FaultKind::frozen, FaultKind::saturated, FaultKind::flipped,
               FaultKind::swapped, FaultKind::gain, FaultKind::silent, FaultKind::frozen_axis}},
      drops_{scene.faults, {FaultKind::drop}},
      bad_samples_{scene.faults, {FaultKind::bad_sample}},
      rng_{scene.seed * 2654435761U + 17},
      noise_{0, p_.noise_mps2_rthz * std::sqrt(p_.rate_hz / 2)},
      clock_rng_{scene.seed * 2654435761U + 71},
      jitter_{1 / std::max(p_.latency_jitter_s, 1e-12)} {
    block_.size = 0;
    // Butterworth low-pass by the bilinear transform, its corner prewarped.
    const double k = std::tan(pi * p_.lowpass_hz / dac_rate_), root2 = std::numbers::sqrt2;
    const double norm = 1 / (1 + root2 * k + k * k);
    biquad_ = {k * k * norm, 2 * k * k * norm, k * k * norm, 2 * (k * k - 1) * norm,
               (1 - root2 * k + k * k) * norm};
}

AccelerometerInfo AccelerometerModel::info() const {
    AccelerometerInfo info{.name = "simulated accelerometer",
                           .rate_hz = p_.rate_hz,
                           .axes = p_.axes,
                           .gravity = p_.gravity == 1,
                           .range_mps2 = p_.range_mps2,
                           .block_s = p_.block_samples / p_.rate_hz};
    for (std::size_t k = 0; k < 3; ++k)
        info.mps2_per_count[k] = k < static_cast<std::size_t>(p_.axes) ? lsb_ : 0;
    if (p_.axis_told == 1) info.shaker_axis = axis_;
    if (p_.axes == 1) info.shaker_axis = {1, 0, 0};
    if (p_.told_low_pass_hz > 0)
        info.response.upper = {.hz = p_.told_low_pass_hz,
                               .error_hz = LowerCorner::of_data_sheet * p_.told_low_pass_hz};
    if (info.gravity) return info;
    const double told = p_.told_high_pass_hz;
    info.response.lower = {
        .hz = std::max(told, 0.0),
        .error_hz = told < 0 ? std::numeric_limits<double>::infinity() : LowerCorner::of_data_sheet * told,
        .poles = told < 0 ? 0 : p_.high_pass_order};
    return info;
}

double AccelerometerModel::low_passed(double a) noexcept {
    const double out = biquad_[0] * a + memory_[0];
    memory_[0] = biquad_[1] * a - biquad_[3] * out + memory_[1];
    memory_[1] = biquad_[2] * a - biquad_[4] * out;
    return out;
}

// Poles in series, by the bilinear transform.
double AccelerometerModel::high_passed(double a) noexcept {
    if (p_.high_pass_hz == 0) return a;
    for (int i = 0; i < p_.high_pass_order; ++i) {
        Pole& pole = poles_[static_cast<std::size_t>(i)];
        pole.out = high_pass_keep_ * pole.out + 0.5 * (1 + high_pass_keep_) * (a - std::exchange(pole.in, a));
        a = pole.out;
    }
    return a;
}

std::array<std::int32_t, 3> AccelerometerModel::converted(double a_base, double t, Quality& quality) {
    const double along = p_.gravity == 1 ? a_base - downhill_ : a_base;  // specific force on the tilted base
    std::array<double, 3> truth{along * axis_[0], along * axis_[1], p_.gravity == 1 ? gravity_ : 0};
    if (turned_.turned()) truth = turned_.force(t);
    if (faults_.at(FaultKind::open, t)) truth = {};
    if (faults_.at(FaultKind::swapped, t)) truth = {truth[1], truth[2], truth[0]};
    const double scale =
        faults_.product_at(FaultKind::gain, t) * (faults_.at(FaultKind::flipped, t) ? -1 : 1);
    const double hum = p_.mains_mps2 * std::sin(2 * pi * p_.mains_hz * t);
    const double stage = faults_.at(FaultKind::saturated, t) ? 1e12 : 1;
    const double top = std::ldexp(1.0, p_.bits - 1) - 1;
    std::array<std::int32_t, 3> counts{};
    for (std::size_t k = 0; k < static_cast<std::size_t>(p_.axes); ++k) {
        double reading = p_.gain[k][k] * truth[k] + p_.offset_mps2[k];
        for (std::size_t i = 0; i < 3; ++i)
            if (i != k) reading += p_.gain[k][i] * truth[i];
        const double c = std::round(stage * (scale * reading + hum + noise_(rng_)) / lsb_);
        if (std::abs(c) > top) quality = quality | Quality::clipped;
        counts[k] = static_cast<std::int32_t>(std::clamp(c, -top, top));
    }
    return counts;
}

// The sample at t: the last one, or a bad one.
std::array<std::int32_t, 3> AccelerometerModel::delivered(double t) noexcept {
    std::array<std::int32_t, 3> counts = last_;
    while (const SceneFault* bad = bad_samples_.take(t)) {
        const double top = std::ldexp(1.0, p_.bits - 1) - 1;
        counts[0] = static_cast<std::int32_t>(std::clamp(std::round(bad->value / lsb_), -top, top));
    }
    return counts;
}

void AccelerometerModel::advance_clock() {
    const double step_s = 1 / p_.rate_hz;
    ahead_s_ += 1e-6 / 60 * p_.clock_drift_ppm_per_min * duration_s(next_, p_.rate_hz) * step_s;
    if (p_.clock_walk_us_rts > 0)
        ahead_s_ += 1e-6 * p_.clock_walk_us_rts * std::sqrt(step_s) * clock_step_(clock_rng_);
    ++next_;
}

// True if the sample at t, with tick next_, is missing.
bool AccelerometerModel::loses(double t) noexcept {
    while (const SceneFault* drop = drops_.take(t))
        dropped_until_ = std::max(dropped_until_, next_) + std::llround(drop->value);
    return next_ < dropped_until_ || faults_.at(FaultKind::silent, t);
}

AccelBlock AccelerometerModel::handed_on() {
    AccelBlock block = block_;
    block.arrived = host_time(filled_s_ + p_.latency_s + jitter_(rng_));
    block_.size = 0;
    return block;
}

std::optional<AccelBlock> AccelerometerModel::step(std::int64_t n, double a_base) {
    const double now = high_passed(low_passed(a_base)), before = std::exchange(before_, now);
    // There is at most one conversion between two DAC samples: the sensor is slower than the DAC.
    const double t = start_s_ + duration_s(next_, p_.rate_hz * (1 + 1e-6 * p_.clock_ppm)) - ahead_s_;
    const double at =
        t * dac_rate_ - (static_cast<double>(n) - 1.5);  // a mean is that of the middle of its step
    if (at > 1) return std::nullopt;
    Quality quality{};
    const auto counts = converted(before + std::clamp(at, 0.0, 1.0) * (now - before), t, quality);
    const AccelTick tick{next_};
    const bool lost = loses(t);
    advance_clock();
    if (lost) {
        gap_ = true;
        if (block_.size == 0) return std::nullopt;
        return handed_on();
    }
    if (faults_.at(FaultKind::frozen, t))
        quality = {};
    else
        last_ = {faults_.at(FaultKind::frozen_axis, t) ? last_[0] : counts[0], counts[1], counts[2]};
    if (block_.size == 0)
        block_ = {.first = tick,
                  .arrived = {},
                  .quality = std::exchange(gap_, false) ? Quality::gap : Quality{},
                  .size = 0};
    block_.quality = block_.quality | quality;
    filled_s_ = t;
    block_.counts[static_cast<std::size_t>(block_.size++)] = delivered(t);
    if (block_.size < p_.block_samples) return std::nullopt;
    return handed_on();
}

}  // namespace shaker::simulated

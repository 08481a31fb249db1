#include "daemon/safety/sample_guard.hpp"

#include <cstdlib>

#include "drivers/time.hpp"

namespace shaker::safety {

namespace {

constexpr double mean_s = 4;            // time constant of the mean (gravity and offset)
constexpr double integral_periods = 2;  // time constant of the leaky integrals
constexpr double settled = 6;           // time constants until an integral is valid
// Time constant of the peak along the axis, the reference of transverse motion.
constexpr double peak_periods = 8;
constexpr double gravity_known_s = 0.25;     // the mean is valid after this time
constexpr double least_gravity = 4;          // m/s^2 across the axis; a smaller one is not checked
constexpr double most_gravity_change = 0.4;  // share of gravity across the axis
constexpr int few_samples = 3;               // consecutive
constexpr double least_along = 1;            // m/s^2; a smaller motion has no direction
constexpr int most_railed = 6;               // consecutive samples
constexpr double least_repeats = 16;         // consecutive samples
constexpr double idle_repeats_s = 1;         // s; longer is counted as a warning
constexpr double least_swing = 8;            // counts; below it equal samples are not suspect
constexpr double longest_window_s = 0.015;
constexpr double sigmas = 6;          // residual caused by noise alone
constexpr double least_motion = 10;   // sigmas; a smaller prediction is not checked
constexpr double gone = 3;            // sigmas; a smaller motion counts as none
constexpr double follows = 0.1;       // share of the slack that a moving base certainly follows
constexpr double open_share = 0.3;    // of the predicted motion; less is an open sensor
constexpr double weak_share = 0.4;    // of the tolerance, when less than open_share is measured
constexpr double too_much = 2;        // times the predicted motion; above it the motion itself is wrong
constexpr double rail_share = 0.999;  // of the range

double dot(const std::array<double, 3>& a, const std::array<double, 3>& b) noexcept {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

std::int64_t largest_count(const AccelBlock& block) noexcept {
    std::int64_t largest = 0;
    for (int i = 0; i < block.size; ++i)
        for (const std::int64_t c : block.counts[static_cast<std::size_t>(i)])
            largest = std::max(largest, std::abs(c));
    return largest;
}

// m/s^2 per count; a calibrated sensor whose axes are swapped has its gains on the cross axes.
double largest_gain(const AccelerometerInfo& sensor) noexcept {
    double largest = 0;
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t k = 0; k < 3; ++k)
            largest = std::max(
                largest, std::abs(i == k ? sensor.mps2_per_count[i] : sensor.cross_mps2_per_count[i][k]));
    return largest;
}

}  // namespace

SampleGuard::SampleGuard(const AccelerometerInfo& sensor, double dac_rate_hz, std::optional<Limits> limits,
                         double frequency)
    : sensor_{sensor},
      dac_rate_hz_{dac_rate_hz},
      limits_{limits.value_or(Limits{})},
      armed_{limits.has_value()},
      lsb_{largest_gain(sensor)},
      motion_{sensor.rate_hz, frequency, dac_rate_hz},
      axis_{sensor.shaker_axis},
      axis_known_{dot(axis_, axis_) > 0} {
    follow_frequency();
    integrals_from_ = static_cast<std::int64_t>(settled * integral_periods * sensor.rate_hz / frequency_);
}

void SampleGuard::expect(const Expectation& expectation) noexcept {
    motion_.expect(expectation);
    if (dot(expectation.axis, expectation.axis) > 0) {
        axis_ = expectation.axis;
        axis_known_ = true;
    }
}

void SampleGuard::hear(const DriveChange& change) noexcept {
    motion_.hear(change);
    const bool ran_empty = change.ramp == 0 && change.stop == 0;
    if (ran_empty && contradicts_) rearm();  // the output takes that trip for a part of the underrun
    const double ramp_s = duration_s(change.ramp, dac_rate_hz_);
    const double steady_s = ramp_s + 1 / change.command.frequency;
    const bool silent = change.stop > 0 || change.command.volts.order() == 0;
    driven_from_ = silent ? -1 : seen_ + static_cast<std::int64_t>(steady_s * sensor_.rate_hz);
}

void SampleGuard::rearm() noexcept {
    tripped_.reset();
    contradicts_ = false;
    window_.clear();
}

void SampleGuard::check(const AccelBlock& block, Ring<Trip>& trips, Warnings& warnings) noexcept {
    const Findings out{trips, warnings};
    watch_gap(block, out);
    const std::int64_t largest = has(block.quality, Quality::clipped) ? largest_count(block) : INT64_MAX;
    for (int i = 0; i < block.size; ++i) {
        const auto& counts = block.counts[static_cast<std::size_t>(i)];
        tick_ = {block.first.n + i};
        judge(counts, at_rail(counts, largest), out);
    }
    next_ = block.first.n + block.size;
}

void SampleGuard::check_early(std::span<const std::array<std::int32_t, 3>> counts, Ring<Trip>& trips,
                              Warnings& warnings) noexcept {
    const Findings out{trips, warnings};
    tick_ = {next_};
    for (const auto& sample : counts) {
        Vector a = sensor_.acceleration(sample);
        if (!std::isfinite(a[0] + a[1] + a[2]))
            trip(Cause::sensor_not_finite, StopKind::soft, a[0] + a[1] + a[2], 0, out);
        if (static_cast<double>(seen_) < gravity_known_s * sensor_.rate_hz) continue;
        for (std::size_t k = 0; k < 3; ++k) a[k] -= mean_[k];
        // check() counts the warnings.
        const Level level{std::numeric_limits<double>::infinity(), limits_.acceleration.abort};
        watch_level(Cause::acceleration, size_along(a), level, StopKind::hard, out);
    }
}

void SampleGuard::judge(const std::array<std::int32_t, 3>& counts, bool railed,
                        const Findings& out) noexcept {
    Vector a = sensor_.acceleration(counts);
    if (!std::isfinite(a[0] + a[1] + a[2])) {
        trip(Cause::sensor_not_finite, StopKind::soft, a[0] + a[1] + a[2], 0, out);
        return;
    }
    ++seen_;
    watch_gravity(a, out);
    const double gain = 1 / std::min(static_cast<double>(seen_), mean_s * sensor_.rate_hz);
    for (std::size_t k = 0; k < 3; ++k) {
        mean_[k] += gain * (a[k] - mean_[k]);
        a[k] -= mean_[k];
    }
    const Predicted predicted = motion_.at(tick_);
    follow_frequency();
    integrate(a);
    watch_counts(counts, railed, predicted, out);
    watch_motion(a, out);
    watch_transverse(a, out);
    watch_residual(a, predicted, out);
}

// The integrals cannot bridge a gap: they restart.
void SampleGuard::watch_gap(const AccelBlock& block, const Findings& out) noexcept {
    const std::int64_t lost = block.first.n - next_;
    if (seen_ == 0 || lost == 0) return;
    tick_ = {next_};
    const double missing_s = duration_s(std::abs(lost), sensor_.rate_hz);
    out.warnings.count(Cause::sensor_missing, static_cast<std::uint64_t>(std::abs(lost)));
    if (missing_s > limits_.missing_s)
        trip(Cause::sensor_missing, StopKind::soft, missing_s, limits_.missing_s, out);
    window_.clear();
    velocity_ = displacement_ = {};
    integrals_from_ =
        seen_ + static_cast<std::int64_t>(settled * integral_periods * sensor_.rate_hz / frequency_);
    railed_ = 0;
    repeats_ = 0;
}

bool SampleGuard::at_rail(const std::array<std::int32_t, 3>& counts, std::int64_t largest) const noexcept {
    const Vector a = sensor_.acceleration(counts);
    for (std::size_t k = 0; k < 3; ++k)
        if (std::abs(std::int64_t{counts[k]}) >= largest ||
            std::abs(a[k]) >= rail_share * limits_.sensor_range_mps2)
            return true;
    return false;
}

void SampleGuard::watch_counts(const std::array<std::int32_t, 3>& counts, bool railed,
                               const Predicted& predicted, const Findings& out) noexcept {
    railed_ = railed ? railed_ + 1 : 0;
    if (railed) out.warnings.count(Cause::sensor_saturated);
    if (railed_ > most_railed) trip(Cause::sensor_saturated, StopKind::soft, railed_, most_railed, out);

    const double value = predicted ? predicted->value : 0;
    if (counts == last_counts_ && seen_ > 1) {
        ++repeats_;
        predicted_low_ = std::min(predicted_low_, value);
        predicted_high_ = std::max(predicted_high_, value);
    } else {
        repeats_ = 0;
        predicted_low_ = predicted_high_ = value;
    }
    watch_stuck_axes(counts, predicted, out);
    last_counts_ = counts;
    watch_frozen(predicted, out);
}

// An axis whose counts do not change while the others do and the base moves is clipped, whatever its
// range.
void SampleGuard::watch_stuck_axes(const std::array<std::int32_t, 3>& counts, const Predicted& predicted,
                                   const Findings& out) noexcept {
    for (std::size_t k = 0; k < 3; ++k) {
        Run& run = axis_runs_[k];
        const double value = predicted ? axis_[k] * predicted->value : 0;
        if (counts[k] != last_counts_[k] || !predicted) {
            run = {0, value, value};
            continue;
        }
        ++run.repeats;
        run.low = std::min(run.low, value);
        run.high = std::max(run.high, value);
        const double least = motion_.expectation().tolerance * predicted->rms + allowance(*predicted);
        if (run.repeats >= most_railed && repeats_ < most_railed &&
            run.high - run.low > std::abs(axis_[k]) * least)
            trip(Cause::sensor_saturated, StopKind::soft, run.repeats + 1, most_railed, out);
    }
}

double SampleGuard::allowance(const PredictedMotion::Sample& predicted) const noexcept {
    const Expectation& e = motion_.expectation();
    return predicted.slack + e.disturbance + sigmas * e.sigma;
}

// A driven base never shows equal samples for a quarter of a period; one at rest may.
void SampleGuard::watch_frozen(const Predicted& predicted, const Findings& out) noexcept {
    if (static_cast<double>(repeats_) == std::ceil(idle_repeats_s * sensor_.rate_hz))
        out.warnings.count(Cause::sensor_frozen);
    const double limit = in_quarter_period(least_repeats);
    const double in_a_row = static_cast<double>(repeats_) + 1;
    if (in_a_row <= limit) return;
    const bool driven = predicted ? predicted_high_ - predicted_low_ > least_swing * lsb_
                                  : driven_from_ >= 0 && seen_ - repeats_ > driven_from_;
    if (driven) trip(Cause::sensor_frozen, StopKind::soft, in_a_row, limit, out);
}

void SampleGuard::integrate(const Vector& a) noexcept {
    const double half_step = 0.5 / sensor_.rate_hz;
    for (std::size_t k = 0; k < 3; ++k) {
        const double before = velocity_[k];
        velocity_[k] = leak_ * before + half_step * (a[k] + last_[k]);
        displacement_[k] = leak_ * displacement_[k] + half_step * (velocity_[k] + before);
    }
    last_ = a;
}

void SampleGuard::watch_motion(const Vector& a, const Findings& out) noexcept {
    const double size = size_along(a);
    watch_level(Cause::acceleration, size, limits_.acceleration, StopKind::hard, out);
    mean_square_ += (1 - leak_) * (size * size - mean_square_);
    watch_level(Cause::acceleration_rms, std::sqrt(mean_square_), limits_.acceleration_rms, StopKind::hard,
                out);
    if (seen_ < integrals_from_) return;
    watch_level(Cause::velocity, size_along(velocity_), limits_.velocity, StopKind::hard, out);
    watch_level(Cause::displacement, size_along(displacement_), limits_.displacement, StopKind::hard, out);
}

void SampleGuard::watch_transverse(const Vector& a, const Findings& out) noexcept {
    if (!axis_known_) return;
    const double on_axis = dot(axis_, a);
    along_peak_ = std::max(std::abs(on_axis), peak_leak_ * along_peak_);
    if (along_peak_ < least_along) return;
    const double across = std::sqrt(std::max(0.0, dot(a, a) - on_axis * on_axis));
    // As many consecutive samples as watch_gravity() needs to separate a change of gravity from
    // motion.
    beside_ = across / along_peak_ > limits_.transverse.abort ? beside_ + 1 : 0;
    const Level level{limits_.transverse.warn, beside_ < few_samples ? std::numeric_limits<double>::infinity()
                                                                     : limits_.transverse.abort};
    watch_level(Cause::transverse, across / along_peak_, level, StopKind::soft, out);
}

// Gravity across the shaker's axis is constant while the sensor works, whatever the drive: a loose lead,
// or a changed sign, axis or gain, shows within a few samples, also at rest. A deviation that the limit of
// transverse motion allows is ignored, because it may be motion.
void SampleGuard::watch_gravity(const Vector& raw, const Findings& out) noexcept {
    if (!axis_known_ || static_cast<double>(seen_) < gravity_known_s * sensor_.rate_hz) return;
    const auto beside = [this](const Vector& v) {
        const double along = dot(axis_, v);
        return Vector{v[0] - along * axis_[0], v[1] - along * axis_[1], v[2] - along * axis_[2]};
    };
    const Vector before = beside(mean_), now = beside(raw);
    const double square = dot(before, before), size = std::sqrt(square);
    if (size < least_gravity) return;
    const double share = dot(before, now) / square;
    const double motion = along_peak_ > least_along ? limits_.transverse.abort * along_peak_ : 0;
    odd_gravity_ =
        size * std::abs(share - 1) > std::max(most_gravity_change * size, motion) ? odd_gravity_ + 1 : 0;
    if (odd_gravity_ < few_samples) return;
    if (std::sqrt(dot(now, now)) < most_gravity_change * size)
        trip(Cause::sensor_open, StopKind::soft, share, most_gravity_change, out);
    else if (share < -most_gravity_change)
        trip(Cause::polarity, StopKind::soft, share, most_gravity_change, out);
    else
        trip(Cause::gravity, StopKind::soft, share, 1 + most_gravity_change, out);
}

// Checks a quarter of a period against the tolerance; against a smaller one if less than open_share of the
// motion is measured; and in any state, rough predictions included, if no motion is measured.
void SampleGuard::watch_residual(const Vector& a, const Predicted& predicted, const Findings& out) noexcept {
    if (!predicted || !axis_known_) {
        window_.clear();
        return;
    }
    window_.add(dot(axis_, a), predicted->value);
    const Expectation& e = motion_.expectation();
    follow_tolerance(e.tolerance);
    const double expected = std::max(predicted->rms, window_.predicted());
    if (!window_.full() || expected <= least_motion * e.sigma) return;
    const double allowed = allowance(*predicted);
    const double limit = tolerance_ * expected + allowed;
    const double residual = window_.residual();
    const double share = window_.gain();
    // A small share is not significant if the prediction is smaller than its own uncertainty.
    const double doubt = weak_share * tolerance_ * expected + allowed;
    const bool weak = share < open_share && window_.predicted() > std::max(doubt, least_motion * e.sigma) &&
                      residual > doubt;
    const bool nothing = window_.measured() < gone * e.sigma &&
                         window_.predicted() > gone * least_motion * e.sigma + follows * predicted->slack;
    if (residual <= limit && !weak && !nothing) return;
    if (static_cast<double>(repeats_) >= least_repeats)
        trip(Cause::sensor_frozen, StopKind::soft, static_cast<double>(repeats_) + 1, least_repeats, out);
    else if (share < -0.5 && window_.measured() <= too_much * window_.predicted())
        trip(Cause::polarity, StopKind::soft, share, open_share, out);
    else if (window_.measured() < open_share * window_.predicted())
        trip(Cause::sensor_open, StopKind::soft, window_.measured() / window_.predicted(), open_share, out);
    else
        trip(Cause::residual,
             window_.measured() > too_much * window_.predicted() ? StopKind::hard : StopKind::soft, residual,
             residual > limit ? limit : std::min(doubt, residual), out);
}

// Samples predicted with the larger tolerance are not checked against a smaller new one.
void SampleGuard::follow_tolerance(double tolerance) noexcept {
    if (tolerance >= tolerance_) {
        tolerance_ = tolerance;
        judged_ = 0;
    } else if (++judged_ > window_.size()) {
        tolerance_ = tolerance;
    }
}

void SampleGuard::watch_level(Cause cause, double value, const Level& level, StopKind kind,
                              const Findings& out) noexcept {
    if (value > level.warn) out.warnings.count(cause);
    if (value > level.abort) trip(cause, kind, value, level.abort, out);
}

double SampleGuard::size_along(const Vector& a) const noexcept {
    return axis_known_ ? std::abs(dot(axis_, a)) : std::sqrt(dot(a, a));
}

double SampleGuard::in_quarter_period(double at_least) const noexcept {
    return std::max(at_least, 0.25 * sensor_.rate_hz / frequency_);
}

void SampleGuard::follow_frequency() noexcept {
    if (motion_.frequency() == frequency_) return;
    frequency_ = motion_.frequency();
    const double periods = frequency_ / sensor_.rate_hz;  // periods per sample
    leak_ = std::exp(-periods / integral_periods);
    peak_leak_ = std::exp(-periods / peak_periods);
    const double samples = std::min(in_quarter_period(4), std::max(4.0, longest_window_s * sensor_.rate_hz));
    window_.resize(static_cast<std::size_t>(std::lround(samples)));
}

void SampleGuard::trip(Cause cause, StopKind kind, double value, double limit, const Findings& out) noexcept {
    if (!armed_ || !limits_.detectors[static_cast<std::size_t>(cause)]) {
        out.warnings.count(cause);
        return;
    }
    if (tripped_ && !(*tripped_ == StopKind::soft && kind == StopKind::hard)) return;
    tripped_ = kind;
    const auto dac = motion_.dac_sample(tick_);
    const Trip trip{.cause = cause,
                    .stop = kind,
                    .on_dac_clock = dac.has_value(),
                    .value = value,
                    .limit = limit,
                    .tick = dac ? std::llround(*dac) : tick_.n};
    contradicts_ = contradicts_prediction(trip);
    // The ring holds more than the few trips that there can be before a release.
    static_cast<void>(out.trips.push(trip));
}

}  // namespace shaker::safety

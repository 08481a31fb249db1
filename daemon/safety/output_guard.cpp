#include "daemon/safety/output_guard.hpp"

#include <cmath>
#include <utility>

#include "drivers/time.hpp"

namespace shaker::safety {

namespace {
constexpr double block_patience = 1.25;  // blocks
}

OutputGuard::OutputGuard(double rate_hz, double accelerometer_rate_hz, std::optional<Limits> limits)
    : rate_hz_{rate_hz},
      accelerometer_rate_hz_{accelerometer_rate_hz},
      limits_{limits.value_or(Limits{})},
      armed_{limits.has_value()} {
    if (accelerometer_rate_hz > 0)
        least_patience_s_ = block_patience * AccelBlock::capacity / accelerometer_rate_hz;
}

// A cause that was reported and has another limit now may be reported again.
void OutputGuard::hold_to(const Limits& limits) noexcept {
    limits_ = limits;
    reported_.reset();
}

std::int64_t OutputGuard::stop_samples(StopKind kind) const noexcept {
    return std::max<std::int64_t>(1, std::llround(limits_.stop_s(kind) * rate_hz_));
}

std::optional<Trip> OutputGuard::check(const OutputSigns& signs, Warnings& warnings) noexcept {
    const bool waits_for_first = signs.silent && signs.judged == 0;
    if (signs.judged != judged_ || waits_for_first) judged_at_ = signs.tick;
    if (signs.judged != judged_ || signs.heard != heard_ || (waits_for_first && signs.heard == 0))
        heard_at_ = signs.tick;
    if (signs.gathered != gathered_ || signs.silent) gathered_at_ = signs.tick;
    const std::optional<Trip> found = find(signs, warnings);
    clamped_ = signs.clamped;
    heard_ = signs.heard;
    judged_ = signs.judged;
    gathered_ = signs.gathered;
    return found;
}

std::optional<Trip> OutputGuard::find(const OutputSigns& s, Warnings& warnings) noexcept {
    if (s.peak_V > limits_.drive.warn) warnings.count(Cause::drive);
    if (s.clamped > clamped_)
        if (const auto t =
                trip(Cause::drive, StopKind::hard, s.largest_clamped_V, s.peak_V, s.tick, warnings))
            return t;
    if (s.peak_V > limits_.drive.abort)
        if (const auto t =
                trip(Cause::drive, StopKind::hard, s.peak_V, limits_.drive.abort, s.tick, warnings))
            return t;
    if (s.played.lost > 0)
        if (const auto t = trip(Cause::underrun, StopKind::hard, static_cast<double>(s.played.lost), 0,
                                s.tick, warnings))
            return t;
    if (const auto t = find_heat(s, warnings)) return t;
    if (accelerometer_rate_hz_ > 0)
        if (const auto t = find_silence(s, warnings)) return t;
    const double still_s = duration_s(s.tick - gathered_at_, rate_hz_);
    if (still_s > limits_.watchdog_s)
        return trip(Cause::watchdog, StopKind::soft, still_s, limits_.watchdog_s, s.tick, warnings);
    return std::nullopt;
}

std::optional<Trip> OutputGuard::find_heat(const OutputSigns& s, Warnings& warnings) noexcept {
    const double block_s = duration_s(s.tick - std::exchange(heated_to_, s.tick), rate_hz_);
    const double square_A2 = limits_.coil_A_per_V * limits_.coil_A_per_V * s.mean_square_V2;
    heat_A2_ -= std::expm1(-block_s / limits_.coil_time_s) * (square_A2 - heat_A2_);
    const double heat_A = std::sqrt(heat_A2_);
    if (heat_A > limits_.coil_A.warn) warnings.count(Cause::coil_heat);
    if (!(heat_A > limits_.coil_A.abort)) return std::nullopt;
    return trip(Cause::coil_heat, StopKind::soft, heat_A, limits_.coil_A.abort, s.tick, warnings);
}

std::optional<Trip> OutputGuard::find_silence(const OutputSigns& s, Warnings& warnings) noexcept {
    const double patience_s = std::max(limits_.missing_s, least_patience_s_);
    const double unheard_s = duration_s(s.tick - heard_at_, rate_hz_);
    if (unheard_s >= patience_s)
        return trip(Cause::sensor_missing, StopKind::soft, unheard_s, patience_s, s.tick, warnings);
    const double unjudged_s = duration_s(s.tick - judged_at_, rate_hz_), most_s = patience_s + held_back_s;
    if (unjudged_s >= most_s)
        return trip(Cause::sensor_missing, StopKind::soft, unjudged_s, most_s, s.tick, warnings);
    const double older_s = growth_of_age(s);
    if (older_s >= most_s)
        return trip(Cause::sensor_missing, StopKind::soft, older_s, most_s, s.tick, warnings);
    return std::nullopt;
}

// Age of the newest checked sample, above its least value. By ticks, a delay that grows as slowly as clocks
// drift is a drift. By stamps it is a growth; but the stamps of a sensor without such a clock are arrivals.
double OutputGuard::growth_of_age(const OutputSigns& s) noexcept {
    if (s.judged == 0) return 0;
    const double now_s = counted_s(s.played.tick, rate_hz_);
    const double ticks_s = by_ticks_.add(now_s, now_s - counted_s(s.checked_to, accelerometer_rate_hz_));
    const Seconds age = s.played.heard - s.checked_arrived;
    return std::max(ticks_s, by_stamps_.add(now_s, age.count()));
}

std::optional<Trip> OutputGuard::trip(Cause cause, StopKind kind, double value, double limit,
                                      std::int64_t tick, Warnings& warnings) noexcept {
    const auto bit = static_cast<std::size_t>(cause);
    if (!armed_ || !limits_.detectors[bit]) {
        warnings.count(cause);
        return std::nullopt;
    }
    if (reported_[bit]) return std::nullopt;
    reported_.set(bit);
    return Trip{
        .cause = cause, .stop = kind, .on_dac_clock = true, .value = value, .limit = limit, .tick = tick};
}

}  // namespace shaker::safety

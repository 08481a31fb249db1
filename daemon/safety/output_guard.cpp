#include "daemon/safety/output_guard.hpp"

#include <algorithm>
#include <cmath>

#include "drivers/data.hpp"
#include "drivers/ticks.hpp"

namespace shaker::safety {

namespace {
constexpr double block_patience = 1.25;  // blocks
}

OutputGuard::OutputGuard(double rate_hz, double accelerometer_rate_hz, std::optional<Limits> limits)
    : rate_hz_{rate_hz},
      limits_{limits.value_or(Limits{})},
      armed_{limits.has_value()},
      has_accelerometer_{accelerometer_rate_hz > 0},
      patience_s_{limits_.missing_s} {
    if (has_accelerometer_)
        patience_s_ = std::max(patience_s_, block_patience * AccelBlock::capacity / accelerometer_rate_hz);
}

std::int64_t OutputGuard::stop_samples(StopKind kind) const noexcept {
    return std::max<std::int64_t>(1, std::llround(limits_.stop_s(kind) * rate_hz_));
}

std::optional<Trip> OutputGuard::check(const OutputSigns& signs, Warnings& warnings) noexcept {
    const bool waits_for_first = signs.silent && signs.signs_of_life == 0;
    if (signs.signs_of_life != signs_of_life_ || waits_for_first) block_at_ = signs.tick;
    if (signs.gathered != gathered_ || signs.silent) gathered_at_ = signs.tick;
    const std::optional<Trip> found = find(signs, warnings);
    clamped_ = signs.clamped;
    signs_of_life_ = signs.signs_of_life;
    gathered_ = signs.gathered;
    return found;
}

std::optional<Trip> OutputGuard::find(const OutputSigns& s, Warnings& warnings) noexcept {
    if (s.peak_V > limits_.drive.warn) warnings.count(Cause::drive);
    if (s.clamped > clamped_)
        if (const auto t =
                trip(Cause::drive, StopKind::hard, s.largest_clamped_V, s.peak_V, s.tick, warnings))
            return t;
    if (s.lost > 0)
        if (const auto t =
                trip(Cause::underrun, StopKind::hard, static_cast<double>(s.lost), 0, s.tick, warnings))
            return t;
    const double silent_s = duration_s(s.tick - block_at_, rate_hz_);
    if (has_accelerometer_ && silent_s >= patience_s_)
        if (const auto t =
                trip(Cause::sensor_missing, StopKind::soft, silent_s, patience_s_, s.tick, warnings))
            return t;
    const double still_s = duration_s(s.tick - gathered_at_, rate_hz_);
    if (still_s > limits_.watchdog_s)
        return trip(Cause::watchdog, StopKind::soft, still_s, limits_.watchdog_s, s.tick, warnings);
    return std::nullopt;
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

#pragma once
// PlayingClock: position of a DAC on its sample counter, from its reports, and detection of stops. Real-time.
#include <chrono>
#include <cstdint>

#include "drivers/data.hpp"

namespace shaker::alsa {

class PlayingClock {
public:
    explicit PlayingClock(double nominal_hz) noexcept : rate_hz_{nominal_hz} {}

    /// The first report of a stream. The rate measured before is kept.
    void begin(const PlayTime& seen) noexcept { anchor_ = last_ = reference_ = seen; }

    /// A further report. Returns the number of samples by which playback lags behind the earliest report of
    /// the last seconds; more than the device's granularity only when it had stopped.
    std::int64_t note(const PlayTime& seen) noexcept {
        const double since_anchor = seconds_between(anchor_, seen);
        if (since_anchor > worth_a_rate_s)
            rate_hz_ = static_cast<double>(seen.tick.n - anchor_.tick.n) / since_anchor;
        const std::int64_t behind = at(reference_, seen.heard) - seen.tick.n;
        if (behind <= 0 || seconds_between(reference_, seen) > reference_lasts_s) reference_ = seen;
        last_ = seen;
        return behind;
    }

    /// The sample playing at `t`, to a few samples.
    [[nodiscard]] std::int64_t tick_at(HostTime t) const noexcept { return at(last_, t); }

private:
    static constexpr double worth_a_rate_s = 2, reference_lasts_s = 2;

    static double seconds_between(const PlayTime& a, const PlayTime& b) noexcept {
        return Seconds{b.heard - a.heard}.count();
    }
    [[nodiscard]] std::int64_t at(const PlayTime& from, HostTime t) const noexcept {
        return from.tick.n + static_cast<std::int64_t>(rate_hz_ * Seconds{t - from.heard}.count());
    }

    double rate_hz_;
    PlayTime anchor_{}, last_{}, reference_{};
};

}  // namespace shaker::alsa

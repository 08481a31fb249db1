#pragma once
// A map from the ticks of one clock to host time: a straight line with its error. Two maps in a row lead from
// one device's ticks to another's.
#include <chrono>
#include <cmath>
#include <cstdint>

#include "drivers/time.hpp"

namespace shaker::calibration {

/// An instant between two ticks of a clock: `fraction` (0 <= fraction < 1) of a tick after `tick`.
template <class Clock>
struct TickInstant {
    Tick<Clock> tick;
    double fraction = 0;
};

/// Linear map from tick k to host time and back: t = time0 + ns_per_tick (k - tick0), with errors of time0
/// and rate. Valid near the time of the fit. Immutable. Integers are subtracted before they become doubles,
/// so hours of ticks and years of nanoseconds lose no precision.
template <class Clock>
class ClockMap {
public:
    /// ns_per_tick > 0. `sigma`: standard deviation of time0. `sigma_rate`: relative standard deviation of
    /// the rate. Neither contains errors common to all stamps, such as their shortest delay.
    ClockMap(Tick<Clock> tick0, HostTime time0, double ns_per_tick, Seconds sigma = {}, double sigma_rate = 0)
        : tick0_{tick0}, time0_{time0}, ns_per_tick_{ns_per_tick}, sigma_{sigma}, sigma_rate_{sigma_rate} {}

    [[nodiscard]] HostTime at(TickInstant<Clock> k) const noexcept {
        const double ns = ns_per_tick_ * (static_cast<double>(k.tick.n - tick0_.n) + k.fraction);
        return time0_ + std::chrono::nanoseconds{std::llround(ns)};
    }
    [[nodiscard]] HostTime at(Tick<Clock> k) const noexcept { return at(TickInstant<Clock>{k}); }

    /// The inverse of at().
    [[nodiscard]] TickInstant<Clock> at(HostTime t) const noexcept {
        const double ticks = static_cast<double>((t - time0_).count()) / ns_per_tick_;
        const double whole = std::floor(ticks);
        return {{tick0_.n + static_cast<std::int64_t>(whole)}, ticks - whole};
    }

    /// Standard deviation of at(k); it increases with the distance from tick0.
    [[nodiscard]] Seconds sigma_at(Tick<Clock> k) const noexcept {
        const double from_rate = sigma_rate_ * 1e-9 * ns_per_tick_ * static_cast<double>(k.n - tick0_.n);
        return Seconds{std::hypot(sigma_.count(), from_rate)};
    }
    [[nodiscard]] double ns_per_tick() const noexcept { return ns_per_tick_; }

private:
    Tick<Clock> tick0_;
    HostTime time0_;
    double ns_per_tick_;
    Seconds sigma_;
    double sigma_rate_;
};

}  // namespace shaker::calibration

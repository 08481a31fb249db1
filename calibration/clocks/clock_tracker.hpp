#pragma once
// Fits one device's clock to host time from stamps that can be late but never early. No memory is allocated
// after construction.
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

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
    /// The tick at which the map is known best.
    [[nodiscard]] Tick<Clock> middle() const noexcept { return tick0_; }

private:
    Tick<Clock> tick0_;
    HostTime time0_;
    double ns_per_tick_;
    Seconds sigma_;
    double sigma_rate_;
};

/// The highest line below all stamps (k_i, t_i) of the last seconds:
///
///     minimise sum_i (t_i - a - b k_i)   subject to   t_i >= a + b k_i for all i
///
/// k: tick, t: host time in ns, b: ns per tick. The solution is the edge of the lower convex hull above the
/// mean tick. Late stamps do not change it, however late they are. Assumption: each stamp is the true time
/// plus a delay > 0 with a constant minimum. Source: Moon, Skelly, Towsley, INFOCOM 1999.
class LineUnderStamps {
public:
    struct Line {
        std::int64_t tick0;  // mean tick of the stamps, rounded
        std::int64_t ns0;    // host time at tick0
        double ns_per_tick;
        double residual_ns;  // mean delay of the stamps above the line
        double sigma_ns;     // standard deviation of ns0
        double sigma_rate;   // relative standard deviation of ns_per_tick
    };
    LineUnderStamps(double ns_per_tick, std::int64_t window_ns);

    void add(std::int64_t tick, std::int64_t ns) noexcept;
    void restart() noexcept;
    [[nodiscard]] const std::optional<Line>& line() const noexcept { return line_; }

private:
    struct Stamp {
        std::int64_t tick;
        std::int64_t ns;
    };
    struct Vertex {
        double x;  // ticks after the oldest stamp
        double y;  // ns after the oldest stamp, minus x at the nominal rate
    };
    [[nodiscard]] const Stamp& stamp(std::size_t i) const noexcept;
    [[nodiscard]] Vertex point(std::size_t i) const noexcept;
    void fit() noexcept;
    [[nodiscard]] Vertex mean() const noexcept;
    void build_hull() noexcept;
    /// Divides the window into parts and averages the height of each part's lowest stamp above the line
    /// through (mean.x, y), ns.
    [[nodiscard]] double lowest_of_parts(Vertex mean, double y) const noexcept;
    void follow_hull(Vertex mean) noexcept;
    void follow_known_rate(Vertex mean) noexcept;
    void set_line(Vertex mean, double y, double excess_rate, double scatter_ns,
                  double known_rate_sigma) noexcept;

    double nominal_ns_;
    std::int64_t window_ns_;
    std::vector<Stamp> stamps_;  // a ring with `size_` stamps from index `oldest_` on
    std::size_t oldest_ = 0;
    std::size_t size_ = 0;
    std::vector<Vertex> hull_;
    std::optional<Line> line_;
    std::int64_t fitted_ns_ = 0;
    double excess_rate_ = 0;  // ns per tick minus nominal, from the last fit of the rate
    double excess_rate_sigma_;
    double scatter_ns_;  // mean delay above the line, from the last fit of the rate
};

/// Follows a device's clock from its (tick, stamp) pairs, added in order. One thread.
///
/// The line is fitted to the last `window`, at most once every half second of stamps. While there are less
/// than 2 s of stamps, the rate is the last known one (at first the nominal one) and only the offset is
/// fitted. The shortest delay between tick and stamp remains in the map, because stamps cannot reveal it.
template <class Clock>
class ClockTracker {
public:
    explicit ClockTracker(double nominal_hz, std::chrono::seconds window = std::chrono::seconds{20})
        : nominal_ns_{1e9 / nominal_hz}, fit_{nominal_ns_, std::chrono::nanoseconds{window}.count()} {}

    /// Ticks must increase; other pairs are ignored.
    void add(Tick<Clock> tick, HostTime stamp) noexcept {
        fit_.add(tick.n, stamp.time_since_epoch().count());
    }
    /// Call it when the ticks have shifted in time (an underrun, a reopened device): forgets the offset and
    /// keeps the rate.
    void restart() noexcept { fit_.restart(); }

    /// The newest fit; empty until the first stamp after the start or a restart.
    [[nodiscard]] std::optional<ClockMap<Clock>> map() const noexcept {
        const auto& line = fit_.line();
        if (!line) return std::nullopt;
        return ClockMap<Clock>{{line->tick0},
                               HostTime{std::chrono::nanoseconds{line->ns0}},
                               line->ns_per_tick,
                               Seconds{1e-9 * line->sigma_ns},
                               line->sigma_rate};
    }
    /// Rate of the device above nominal, 1e-6; 0 before the first stamp.
    [[nodiscard]] double ppm() const noexcept {
        return fit_.line() ? 1e6 * (nominal_ns_ / fit_.line()->ns_per_tick - 1) : 0.0;
    }
    /// Standard deviation of ppm(); infinite before the first stamp.
    [[nodiscard]] double ppm_sigma() const noexcept {
        return fit_.line() ? 1e6 * fit_.line()->sigma_rate : std::numeric_limits<double>::infinity();
    }
    /// Mean delay of the stamps minus the shortest one; 0 before the first stamp.
    [[nodiscard]] Seconds residual() const noexcept {
        return Seconds{fit_.line() ? 1e-9 * fit_.line()->residual_ns : 0.0};
    }

private:
    double nominal_ns_;
    LineUnderStamps fit_;
};

}  // namespace shaker::calibration

#pragma once
// Fits one device's clock to host time from stamps that may only be late. Takes no memory after it is built.
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "calibration/clocks/clock_map.hpp"
#include "drivers/time.hpp"

namespace shaker::calibration {

/// The line under stamps of the last seconds: one edge of their lower convex hull, the one that spans their
/// mean tick. Of all lines with no stamp below, this one has the least mean distance to the stamps (Moon,
/// Skelly, Towsley, INFOCOM 1999), so late stamps do not pull it, however late.
class LineUnderStamps {
public:
    struct Line {
        std::int64_t tick0;  // mean of the stamps' ticks
        std::int64_t ns0;    // host time there
        double ns_per_tick;
        double residual_ns;  // mean delay of the stamps beyond the shortest one
        double sigma_ns;     // of ns0, for delays that are independent of one another
        double sigma_rate;   // of ns_per_tick, as a part of it
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
        double y;  // ns after the oldest stamp, less x at the nominal rate
    };
    [[nodiscard]] const Stamp& stamp(std::size_t i) const noexcept;
    [[nodiscard]] Vertex point(std::size_t i) const noexcept;
    void fit() noexcept;
    [[nodiscard]] Vertex mean() const noexcept;
    void build_hull() noexcept;
    /// Mean over the parts of the window of their lowest stamp above the line through `mean` at y.
    [[nodiscard]] double lowest_of_parts(Vertex mean, double y) const noexcept;
    void follow_hull(Vertex mean) noexcept;
    void follow_known_rate(Vertex mean) noexcept;
    void set_line(Vertex mean, double y, double excess_rate, double scatter_ns,
                  double known_rate_sigma) noexcept;

    double nominal_ns_;
    std::int64_t window_ns_;
    std::vector<Stamp> stamps_;  // a ring: `size_` of them from `oldest_` on
    std::size_t oldest_ = 0;
    std::size_t size_ = 0;
    std::vector<Vertex> hull_;
    std::optional<Line> line_;
    std::int64_t fitted_ns_ = 0;
    double excess_rate_ = 0;  // ns a tick above nominal, of the last fit that could tell
    double excess_rate_sigma_;
    double scatter_ns_;  // of delays beyond the shortest, likewise
};

/// A device's clock: give it every (tick, stamp) pair in order, ask for the map when needed. One thread.
///
/// The line is fitted to the last `window`, anew at most every half second of stamps. Until 2 s of stamps are
/// there, the rate is the one known from before (at first the nominal one) and only the offset is fitted. The
/// shortest delay between the tick and its stamp stays in the map: no stamp can tell it.
template <class Clock>
class ClockTracker {
public:
    explicit ClockTracker(double nominal_hz, std::chrono::seconds window = std::chrono::seconds{20})
        : nominal_ns_{1e9 / nominal_hz}, fit_{nominal_ns_, std::chrono::nanoseconds{window}.count()} {}

    /// Ticks must rise; a pair whose tick does not is left out.
    void add(Tick<Clock> tick, HostTime stamp) noexcept {
        fit_.add(tick.n, stamp.time_since_epoch().count());
    }
    /// The ticks have lost their place in time (an underrun, a device opened again): forgets the offset,
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
    /// How much faster than nominal the device runs, in millionths; 0 before the first stamp.
    [[nodiscard]] double ppm() const noexcept {
        return fit_.line() ? 1e6 * (nominal_ns_ / fit_.line()->ns_per_tick - 1) : 0.0;
    }
    /// Standard deviation of ppm(), for delays that are independent of one another; infinite before the first
    /// stamp.
    [[nodiscard]] double ppm_sigma() const noexcept {
        return fit_.line() ? 1e6 * fit_.line()->sigma_rate : std::numeric_limits<double>::infinity();
    }
    /// How late the stamps are on average, beyond the shortest delay.
    [[nodiscard]] Seconds residual() const noexcept {
        return Seconds{fit_.line() ? 1e-9 * fit_.line()->residual_ns : 0.0};
    }

private:
    double nominal_ns_;
    LineUnderStamps fit_;
};

}  // namespace shaker::calibration

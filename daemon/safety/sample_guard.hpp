#pragma once
// SampleGuard: checks every accelerometer sample against the limits, in the thread that reads it.
// Real-time: no allocation, locks or log after construction.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "daemon/safety/limits.hpp"
#include "daemon/safety/predicted_motion.hpp"
#include "daemon/safety/trip.hpp"
#include "drivers/devices.hpp"
#include "drivers/handover.hpp"

namespace shaker::safety {

/// Measured and predicted motion over the last quarter of a period.
/// Running sums over the newest samples. They are recomputed each time the window has been filled again,
/// so rounding errors do not accumulate.
class ResidualWindow {
public:
    static constexpr std::size_t most_samples = 2048;

    /// Clears the window and sets its length in samples (1..most_samples).
    void resize(std::size_t samples) noexcept {
        size_ = std::clamp<std::size_t>(samples, 1, most_samples);
        clear();
    }
    void clear() noexcept { filled_ = next_ = 0, mm_ = pp_ = mp_ = 0; }
    void add(double measured, double predicted) noexcept {
        const bool full = filled_ == size_;
        Pair& here = pairs_[next_];
        if (full) count(here, -1);
        here = {measured, predicted};
        count(here, 1);
        if (!full) ++filled_;
        if (++next_ < size_) return;
        next_ = 0;
        mm_ = pp_ = mp_ = 0;
        for (std::size_t i = 0; i < filled_; ++i) count(pairs_[i], 1);
    }
    [[nodiscard]] std::size_t size() const noexcept { return size_; }
    [[nodiscard]] bool full() const noexcept { return filled_ == size_; }
    /// Rms of the measured and the predicted motion and of their difference.
    [[nodiscard]] double measured() const noexcept { return root(mm_); }
    [[nodiscard]] double predicted() const noexcept { return root(pp_); }
    [[nodiscard]] double residual() const noexcept { return root(mm_ - 2 * mp_ + pp_); }
    /// Measured / predicted motion by least squares; 1 is ideal. 0 when no motion is predicted.
    [[nodiscard]] double gain() const noexcept { return pp_ > 0 ? mp_ / pp_ : 0; }

private:
    struct Pair {
        double measured = 0, predicted = 0;
    };
    void count(const Pair& p, double sign) noexcept {
        mm_ += sign * p.measured * p.measured;
        pp_ += sign * p.predicted * p.predicted;
        mp_ += sign * p.measured * p.predicted;
    }
    [[nodiscard]] double root(double sum) const noexcept {
        return filled_ > 0 ? std::sqrt(std::max(0.0, sum) / static_cast<double>(filled_)) : 0;
    }

    std::array<Pair, most_samples> pairs_{};
    std::size_t size_ = 1, filled_ = 0, next_ = 0;
    double mm_ = 0, pp_ = 0, mp_ = 0;
};

/// Checks until the first trip: acceleration along the shaker's axis, and its rms over two periods; velocity
/// and displacement (leaky integrals with a time constant of two periods: 0.7 % low at the drive's frequency,
/// settled to 1 % ten periods after a step of the sensor's offset); motion across the axis; change of gravity
/// across the axis; samples at the end of the range; equal samples; gaps; residual to the prediction.
///
/// Mean (gravity and offset): low-pass of the signal, time constant 4 s, subtracted before all checks of
/// motion. While the axis is unknown, the length of the vector replaces the component along it.
///
/// After the first trip, only a hard cause after a soft one trips, until rearm().
class SampleGuard {
public:
    /// frequency: Hz, of the synthesiser's silent start. Without limits all findings are counted as
    /// warnings and nothing trips.
    SampleGuard(const AccelerometerInfo& sensor, double dac_rate_hz, std::optional<Limits> limits,
                double frequency = 20);

    void expect(const Expectation& expectation) noexcept;
    void hear(const DriveChange& change) noexcept;
    void rearm() noexcept;
    /// Replaces the limits from now on.
    void hold_to(const Limits& limits) noexcept { limits_ = limits; }
    /// Checks the levels of samples whose place in time is not known yet: finite, and acceleration below its
    /// abort level. check() gets the same samples later. Pushes a trip into `trips` at once.
    void check_early(std::span<const std::array<std::int32_t, 3>> counts, Ring<Trip>& trips,
                     Warnings& warnings) noexcept;
    /// Checks a block. Pushes a trip into `trips` at once.
    void check(const AccelBlock& block, Ring<Trip>& trips, Warnings& warnings) noexcept;

private:
    using Vector = std::array<double, 3>;
    using Predicted = std::optional<PredictedMotion::Sample>;
    /// Destination of findings.
    struct Findings {
        Ring<Trip>& trips;
        Warnings& warnings;
    };

    void judge(const std::array<std::int32_t, 3>& counts, bool railed, const Findings& out) noexcept;
    void watch_gap(const AccelBlock& block, const Findings& out) noexcept;
    void watch_counts(const std::array<std::int32_t, 3>& counts, bool railed, const Predicted& predicted,
                      const Findings& out) noexcept;
    void watch_frozen(const Predicted& predicted, const Findings& out) noexcept;
    void watch_stuck_axes(const std::array<std::int32_t, 3>& counts, const Predicted& predicted,
                          const Findings& out) noexcept;
    /// Residual that is allowed at this prediction apart from the tolerance, m/s^2 rms.
    [[nodiscard]] double allowance(const PredictedMotion::Sample& predicted) const noexcept;
    void watch_motion(const Vector& a, const Findings& out) noexcept;
    void watch_transverse(const Vector& a, const Findings& out) noexcept;
    void watch_gravity(const Vector& raw, const Findings& out) noexcept;
    void watch_residual(const Vector& a, const Predicted& predicted, const Findings& out) noexcept;
    void watch_level(Cause cause, double value, const Level& level, StopKind kind,
                     const Findings& out) noexcept;
    /// True for a sample at the end of the sensor's range: beyond the data sheet's range or, in a
    /// block marked as clipped, equal to the block's largest count.
    [[nodiscard]] bool at_rail(const std::array<std::int32_t, 3>& counts,
                               std::int64_t largest) const noexcept;
    [[nodiscard]] double size_along(const Vector& a) const noexcept;
    [[nodiscard]] double in_quarter_period(double at_least) const noexcept;
    void integrate(const Vector& a) noexcept;
    void follow_tolerance(double tolerance) noexcept;
    void follow_frequency() noexcept;
    void trip(Cause cause, StopKind kind, double value, double limit, const Findings& out) noexcept;

    AccelerometerInfo sensor_;
    double dac_rate_hz_;
    Limits limits_;
    bool armed_;  // limits were given
    double lsb_;  // m/s^2 per count of the coarsest axis
    PredictedMotion motion_;
    ResidualWindow window_;
    double tolerance_ = 0;    // share of the predicted rms, of the oldest prediction in the window
    std::size_t judged_ = 0;  // samples since a smaller tolerance was set
    Vector axis_;
    bool axis_known_;

    std::optional<StopKind> tripped_;
    bool contradicts_ = false;  // the newest trip contradicts the prediction
    AccelTick tick_;            // of the sample being checked
    std::int64_t next_ = 0;     // expected tick of the next sample
    std::int64_t seen_ = 0;     // number of samples
    Vector mean_{}, last_{}, velocity_{}, displacement_{};
    double mean_square_ = 0;           // of the acceleration along the axis, m^2/s^4
    double leak_ = 0;                  // factor of the integrals per sample
    double frequency_ = 0;             // Hz, for which leak_ and the windows are set
    std::int64_t integrals_from_ = 0;  // `seen_` at which they are settled
    double along_peak_ = 0, peak_leak_ = 0;
    int odd_gravity_ = 0, beside_ = 0;  // consecutive samples
    int railed_ = 0;                    // consecutive samples
    std::array<std::int32_t, 3> last_counts_{};
    struct Run {  // consecutive equal counts of one axis
        int repeats = 0;
        double low = 0, high = 0;  // range of the prediction during the run
    };
    std::array<Run, 3> axis_runs_{};
    std::int64_t repeats_ = 0;                       // number of repetitions of last_counts_
    double predicted_low_ = 0, predicted_high_ = 0;  // range of the prediction since then
    std::int64_t driven_from_ = -1;  // `seen_` since which the drive has been steady; < 0: silent
};

}  // namespace shaker::safety

#pragma once
// Every accelerometer sample against the limits, in the thread that reads it. Real-time: nothing allocates,
// locks or logs once built.
#include <array>
#include <cstdint>
#include <optional>

#include "daemon/control/limits.hpp"
#include "daemon/control/predicted_motion.hpp"
#include "daemon/control/residual_window.hpp"
#include "daemon/control/trip.hpp"
#include "drivers/devices.hpp"
#include "drivers/handover.hpp"

namespace shaker {

/// What is judged, each until the first trip: size of the acceleration along the shaker's axis, of velocity
/// and displacement (leaky integrals with a time constant of two periods: 0.7 % short at the drive's
/// frequency, settled to 1 % after ten periods of a step of the sensor's offset), motion across the axis, a
/// change of gravity across it, the end of the sensor's range, equal samples, gaps, and the residual to the
/// prediction. The constant part of the signal (gravity) is followed with a time constant of 4 s. Until the
/// axis is known the size of the vector stands for the motion along it.
///
/// After the first trip nothing trips but a hard cause after a soft one, until rearm().
class SampleGuard {
public:
    /// frequency: of the synthesiser's silent start, Hz. Without limits everything is counted as a warning
    /// and nothing trips.
    SampleGuard(const AccelerometerInfo& sensor, double dac_rate_hz, std::optional<Limits> limits,
                double frequency = 20);

    void expect(const Expectation& expectation) noexcept;
    void hear(const DriveChange& change) noexcept;
    void rearm() noexcept;
    /// Other levels from now on.
    void hold_to(const Limits& limits) noexcept { limits_ = limits; }
    /// Judges a block. What trips goes into `trips` at once.
    void check(const AccelBlock& block, Ring<Trip>& trips, Warnings& warnings) noexcept;

private:
    using Vector = std::array<double, 3>;
    using Predicted = std::optional<PredictedMotion::Sample>;
    /// Where findings go.
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
    /// Residual that is no fault beside this prediction, rms in m/s^2.
    [[nodiscard]] double allowance(const PredictedMotion::Sample& predicted) const noexcept;
    void watch_motion(const Vector& a, const Findings& out) noexcept;
    void watch_transverse(const Vector& a, const Findings& out) noexcept;
    void watch_gravity(const Vector& raw, const Findings& out) noexcept;
    void watch_residual(const Vector& a, const Predicted& predicted, const Findings& out) noexcept;
    void watch_level(Cause cause, double value, const Level& level, StopKind kind,
                     const Findings& out) noexcept;
    /// A sample at the end of the sensor's range, by the data sheet or, in a block marked as clipped, by
    /// being the largest.
    [[nodiscard]] bool at_rail(const std::array<std::int32_t, 3>& counts,
                               std::int64_t largest) const noexcept;
    [[nodiscard]] double size_along(const Vector& a) const noexcept;
    [[nodiscard]] double in_quarter_period(double at_least) const noexcept;
    void integrate(const Vector& a) noexcept;
    void follow_tolerance(double told) noexcept;
    void follow_frequency() noexcept;
    void trip(Cause cause, StopKind kind, double value, double limit, const Findings& out) noexcept;

    AccelerometerInfo sensor_;
    double dac_rate_hz_;
    Limits limits_;
    bool armed_;  // limits were given
    double lsb_;  // the coarsest axis', m/s^2
    PredictedMotion motion_;
    ResidualWindow window_;
    double tolerance_ = 0;    // of the oldest prediction in the window
    std::size_t judged_ = 0;  // samples since closer bounds were told
    Vector axis_;
    bool axis_known_;

    std::optional<StopKind> tripped_;
    AccelTick tick_;         // of the sample being judged
    std::int64_t next_ = 0;  // tick that should come next
    std::int64_t seen_ = 0;  // samples
    Vector mean_{}, last_{}, velocity_{}, displacement_{};
    double leak_ = 0;                  // of the integrals, a sample
    double frequency_ = 0;             // that leak_ and the windows are for
    std::int64_t integrals_from_ = 0;  // `seen_` from which they are settled
    double along_peak_ = 0, peak_leak_ = 0;
    int odd_gravity_ = 0, beside_ = 0;  // samples in a row
    int railed_ = 0;                    // samples in a row
    std::array<std::int32_t, 3> last_counts_{};
    struct Run {  // of equal counts
        int repeats = 0;
        double low = 0, high = 0;  // of the prediction meanwhile
    };
    std::array<Run, 3> axis_runs_{};
    std::int64_t repeats_ = 0;                       // of last_counts_
    double predicted_low_ = 0, predicted_high_ = 0;  // since then
    std::int64_t driven_from_ = -1;  // `seen_` from which the drive has been steady; < 0: silent
};

}  // namespace shaker

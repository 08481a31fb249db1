#pragma once
// Guards of the control thread: of each window of whole periods, and of the accelerometer's clock.
// SampleGuard (sample_guard.hpp) checks every sample.
#include <array>
#include <cmath>
#include <complex>
#include <optional>

#include "calibration/clocks/timebase.hpp"
#include "daemon/control/equaliser.hpp"
#include "daemon/control/harmonic_estimator.hpp"
#include "daemon/control/identification.hpp"
#include "daemon/safety/limits.hpp"
#include "daemon/safety/trip.hpp"

namespace shaker::safety {

/// A window and the state of plant and loop it is compared with.
struct JudgedWindow {
    const control::PeriodEstimate& estimate;
    const control::PeriodWindow& motion;
    std::array<std::complex<double>, max_harmonics>
        response{};                    // m/s^2 per V at f, 2f, ...; identified, or from the data sheet
    Harmonics<Acceleration> target{};  // m/s^2; all 0 while there is no target
    control::Equaliser::Report report{};
    double noise = 0;       // m/s^2, sd of one part of an amplitude in a window with the drive off
    std::int64_t tick = 0;  // DAC sample at the end of the window
    bool followed = false;  // the equaliser has set the drive during the window
};

class PeriodGuard {
public:
    explicit PeriodGuard(const Limits& limits) : limits_{limits} {}
    /// Replaces the limits from now on.
    void hold_to(const Limits& limits) noexcept { limits_ = limits; }

    /// Checks a window; returns the first trip, counts warnings. With measured harmonics y_q, drive
    /// u_q, response h_q, target r_q, the norm over all harmonics, and the noise floor n = 30 sd
    /// sqrt(32), in this order:
    /// sensor_not_finite: y is not finite. sensor_frozen, sensor_open: |h u| > n but |y| < 0.02 |h
    /// u|, without or with noise in the samples (cable, mounting). transverse: motion across the axis
    /// / along it at q = 1, 2 above its limit. gain_limit: |h u| > 4 |r|. loop_divergence: the
    /// equaliser failed, or its error exceeds 0.5 after it was locked. harmonic_band: after it was
    /// locked, |20 lg |y_q / r_q|| > 3 dB for a harmonic of at least 0.1 |r|, in two windows in a
    /// row.
    /// The last three need a target that the equaliser has followed (w.followed).
    std::optional<Trip> check(const JudgedWindow& window, Warnings& warnings);
    /// Checks an identified response. sensor_open: no harmonic has coherence >= 0.5. gain_limit: gain above 4
    /// or, once ended, below 1/4 of the data sheet's; before the end a low gain may be a base that still
    /// sticks. polarity: phase of h_1 more than 90 degrees from the data sheet's; checked only if
    /// `axis_known`, because otherwise the sign of the sensor's axis is unknown.
    std::optional<Trip> check(const control::IdentifiedResponse& response, bool axis_known, bool ended,
                              std::int64_t tick) const;
    /// Call for a new target or a drive that starts: nothing is compared with the target until the
    /// loop is locked again.
    void settling() noexcept { near_ = false, off_ = 0; }

private:
    [[nodiscard]] bool on(Cause cause) const { return limits_.detectors[static_cast<std::size_t>(cause)]; }
    std::optional<Trip> judge_target(const JudgedWindow& window, Warnings& warnings);

    Limits limits_;
    bool near_ = false;
    int off_ = 0;  // consecutive windows with a harmonic out of its band
};

/// Checks that the rate of the accelerometer's clock relative to the DAC's clock stays constant.
/// A constant error of the rate is measured and corrected. A change of the rate by more than `most_ppm` in a
/// run indicates a faulty sensor and is counted as a warning; the drive continues.
class ClockGuard {
public:
    explicit ClockGuard(double accelerometer_rate_hz) : rate_hz_{accelerometer_rate_hz} {}

    static constexpr double most_ppm = 200;

    /// DAC samples per tick by the newest maps around `tick`. Counts a warning when the rate has changed.
    double check(const calibration::Timebase& timebase, AccelTick tick, Warnings& warnings) noexcept {
        const double apart_s = seconds(timebase.at(tick)) - seconds(timebase.at(AccelTick{tick.n - apart}));
        const double ppm = 1e6 * (apart_s * rate_hz_ / apart - 1);
        if (std::isnan(first_ppm_)) first_ppm_ = ppm;
        if (std::abs(ppm - first_ppm_) > most_ppm) warnings.count(Cause::clock);
        return apart_s * timebase.dac_rate_hz() / apart;
    }
    /// The next check() measures a new reference rate.
    void reset() noexcept { first_ppm_ = NAN; }

private:
    static constexpr std::int64_t apart = 4000;  // ticks over which the rate is measured
    double rate_hz_;
    double first_ppm_ = NAN;
};

}  // namespace shaker::safety

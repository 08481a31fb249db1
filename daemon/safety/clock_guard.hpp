#pragma once
// Checks that the rate of the accelerometer's clock relative to the DAC's clock stays constant.
#include <cmath>

#include "calibration/clocks/timebase.hpp"
#include "daemon/safety/trip.hpp"

namespace shaker::safety {

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

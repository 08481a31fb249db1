#pragma once
// Whether the accelerometer's clock still runs as it did against the DAC's.
#include <cmath>

#include "calibration/clocks/timebase.hpp"
#include "daemon/safety/trip.hpp"

namespace shaker::safety {

/// A rate that is off is measured and corrected; one that changes by more than `most_ppm` within a run tells
/// of a sensor in trouble: it is counted as a warning, the drive goes on.
class ClockGuard {
public:
    explicit ClockGuard(double accelerometer_rate_hz) : rate_hz_{accelerometer_rate_hz} {}

    static constexpr double most_ppm = 200;

    /// DAC samples a tick by the newest maps around `tick`; counts a warning when that has moved.
    double check(const calibration::Timebase& timebase, AccelTick tick, Warnings& warnings) noexcept {
        const double apart_s = seconds(timebase.at(tick)) - seconds(timebase.at(AccelTick{tick.n - apart}));
        const double ppm = 1e6 * (apart_s * rate_hz_ / apart - 1);
        if (std::isnan(first_ppm_)) first_ppm_ = ppm;
        if (std::abs(ppm - first_ppm_) > most_ppm) warnings.count(Cause::clock);
        return apart_s * timebase.dac_rate_hz() / apart;
    }
    /// Looks afresh.
    void reset() noexcept { first_ppm_ = NAN; }

private:
    static constexpr std::int64_t apart = 4000;  // ticks
    double rate_hz_;
    double first_ppm_ = NAN;
};

}  // namespace shaker::safety

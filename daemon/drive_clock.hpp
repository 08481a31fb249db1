#pragma once
// Accelerometer samples on the drive's time, from arrival stamps alone: late by the sensor's least delay.
#include "calibration/clock_tracker.hpp"
#include "drivers/data.hpp"

namespace shaker {

/// Hears of a block that was played; after lost time the map begins anew.
inline void follow(ClockTracker<DacClock>& dac, const PlayTime& played) noexcept {
    if (played.lost > 0)
        dac.restart();
    else
        dac.add(played.tick, played.heard);
}

/// Two clock maps joined over host time: accelerometer tick to host time to DAC sample.
class DriveClock {
public:
    DriveClock(double dac_rate_hz, double accelerometer_rate_hz)
        : dac_rate_hz_{dac_rate_hz}, dac_{dac_rate_hz}, accelerometer_{accelerometer_rate_hz} {}
    void add(const PlayTime& played) noexcept { follow(dac_, played); }
    /// A block arrives when its last sample has been taken.
    void add(const AccelBlock& block) noexcept {
        accelerometer_.add({block.first.n + block.size - 1}, block.arrived);
    }
    [[nodiscard]] const ClockTracker<DacClock>& dac() const noexcept { return dac_; }
    [[nodiscard]] const ClockTracker<AccelerometerClock>& accelerometer() const noexcept {
        return accelerometer_;
    }
    [[nodiscard]] double dac_rate_hz() const noexcept { return dac_rate_hz_; }
    /// Both devices have been heard of.
    [[nodiscard]] bool ready() const noexcept { return dac_.map() && accelerometer_.map(); }
    /// Master time of an accelerometer sample by the newest maps; only when ready().
    [[nodiscard]] MasterTime master(AccelTick tick) const noexcept {
        const TickInstant<DacClock> k = dac_.map()->at(accelerometer_.map()->at(tick));
        return master_time((static_cast<double>(k.tick.n) + k.fraction) / dac_rate_hz_);
    }

private:
    double dac_rate_hz_;
    ClockTracker<DacClock> dac_;
    ClockTracker<AccelerometerClock> accelerometer_;
};

}  // namespace shaker

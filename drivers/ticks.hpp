#pragma once
// Ticks into seconds. Only these functions and calibration/clocks divide a count of ticks by a rate
// (tests/tick_times).
#include <cstdint>

#include "drivers/time.hpp"

namespace shaker {

/// Duration of `ticks` ticks of a device at `rate_hz`, s.
constexpr double duration_s(std::int64_t ticks, double rate_hz) noexcept {
    return static_cast<double>(ticks) / rate_hz;
}

/// Time of a tick by the device's own count at `rate_hz`: seconds since its tick 0.
template <class Clock>
constexpr double counted_s(Tick<Clock> tick, double rate_hz) noexcept {
    return duration_s(tick.n, rate_hz);
}

/// Master time of a DAC sample: exact, because the DAC's count is the master clock.
constexpr MasterTime master_time(DacTick tick, double dac_rate_hz) noexcept {
    return master_time(counted_s(tick, dac_rate_hz));
}

}  // namespace shaker

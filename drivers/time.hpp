#pragma once
// Times and ticks typed by clock: ticks of different devices and host time do not mix. Only the functions
// below and calibration/clocks divide a count of ticks by a rate (tests/tick_times).
#include <chrono>
#include <compare>
#include <cstdint>

namespace shaker {

using Seconds = std::chrono::duration<double>;

/// The host's monotonic clock. Only executors and drivers read it; a simulated rig has virtual time.
struct HostClock {
    using duration = std::chrono::nanoseconds;
    using rep = duration::rep;
    using period = duration::period;
    using time_point = std::chrono::time_point<HostClock, duration>;
    static constexpr bool is_steady = true;
};
using HostTime = HostClock::time_point;

/// Master time: seconds since the DAC's sample 0 (or on a recorded session's own clock), as a double:
/// after 10 weeks it still resolves 1 ns.
struct MasterClock {
    using duration = Seconds;
    using rep = duration::rep;
    using period = duration::period;
    using time_point = std::chrono::time_point<MasterClock, duration>;
    static constexpr bool is_steady = true;
};
using MasterTime = MasterClock::time_point;

/// Seconds since master time zero.
constexpr double seconds(MasterTime t) noexcept { return t.time_since_epoch().count(); }
constexpr MasterTime master_time(double s) noexcept { return MasterTime{Seconds{s}}; }

/// Sample counter of one device.
template <class Clock>
struct Tick {
    std::int64_t n{};
    auto operator<=>(const Tick&) const = default;
};
using DacTick = Tick<struct DacClock>;              // one per sample the shaker is fed
using AccelTick = Tick<struct AccelerometerClock>;  // one per accelerometer sample
using CameraTick = Tick<struct CameraClock>;        // one per exposure, counting missed ones
using CameraStamp = Tick<struct CameraStampClock>;  // nanosecond of a camera's own clock

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

#pragma once
// Times and ticks typed by clock: ticks of different devices and host time do not mix.
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

}  // namespace shaker

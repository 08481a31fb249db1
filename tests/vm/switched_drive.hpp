#pragma once
// A drive on real devices with enable output and abort input, as the daemon plays it.
#include <optional>

#include "daemon/safety/trip.hpp"
#include "drivers/devices.hpp"

namespace shaker {

/// Times of CLOCK_MONOTONIC at which the samples are heard.
struct SwitchedDrive {
    HostTime from{}, to{};             // first sample of the drive; sample behind the last one
    std::optional<safety::Trip> trip;  // the first one
    HostTime ramp{};                   // first sample of its ramp
};

/// Drives for `seconds`, or until a trip, and plays the end.
SwitchedDrive drive_switched(Rig& rig, double seconds);

}  // namespace shaker

#pragma once
// A drive on real devices with an abort input, as the daemon plays it.
#include <optional>

#include "daemon/safety/trip.hpp"
#include "drivers/devices.hpp"

namespace shaker {

struct SwitchedDrive {
    std::optional<safety::Trip> trip;  // the first one
    HostTime ramp{};                   // CLOCK_MONOTONIC at which the first sample of its ramp is heard
};

/// Drives for `seconds`, or until a trip, and plays the end.
SwitchedDrive drive_switched(Rig& rig, double seconds);

}  // namespace shaker

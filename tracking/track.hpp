#pragma once
// Fix and Track: position of a target in one frame.
#include <limits>

#include "drivers/time.hpp"

namespace shaker::tracking {

/// degraded: found, but partly hidden, saturated or blurred. reacquired: first good frame after a loss.
enum class TrackState { ok, degraded, lost, reacquired };

/// One target in one frame, px. Pixel centres are at whole numbers. NaN when lost.
struct Fix {
    double x_px = std::numeric_limits<double>::quiet_NaN();
    double y_px = std::numeric_limits<double>::quiet_NaN();
    double sd_px = std::numeric_limits<double>::quiet_NaN();  // standard deviation along the shaker's axis
    TrackState state = TrackState::lost;
};

/// A Fix in metres along the shaker's axis, on master time.
struct Track {
    CameraTick tick;
    MasterTime time;
    Fix fix;
    double x_m = std::numeric_limits<double>::quiet_NaN();
    double sd_m = std::numeric_limits<double>::quiet_NaN();
};

constexpr bool found(TrackState s) noexcept { return s != TrackState::lost; }

}  // namespace shaker::tracking

#pragma once
// The states of a run with the data that have a meaning only in them, in the order of RunState.
#include <cmath>
#include <variant>

#include "daemon/run/state.hpp"

namespace shaker::run {

struct Init {};
struct Quiet {};
struct Idle {
    bool ended = false;  // the one run is over
};
struct Armed {};
struct Identify {};
struct Ramp {};
/// The drive is kept at its target: it settles, then it is measured.
struct Run {
    double from_s = 0;               // master time of the set-point
    double kept_from_s = -INFINITY;  // the drive has been where it should be since
    bool measuring = false;
};
struct RampDown {};
struct Tripped {
    enum class Phase {
        latched,   // what led to the trip is still on its way
        excused,   // it was the DAC's fault: the drive comes back by itself
        released,  // excused, and the output was asked to let go
        silent,    // until it is cleared
        clearing,  // cleared, until the output has let go
    };
    double at_s = 0;  // master time
    Phase phase = Phase::latched;
};

using State = std::variant<Init, Quiet, Idle, Armed, Identify, Ramp, Run, RampDown, Tripped>;

/// The published name of a state.
inline RunState named(const State& state) noexcept { return static_cast<RunState>(state.index()); }

}  // namespace shaker::run

#pragma once
// One struct for each state of a run, in the order of RunState, with the data that only this state needs.
#include <cmath>
#include <variant>

#include "daemon/run/state.hpp"
#include "daemon/safety/loop_check.hpp"

namespace shaker::run {

struct Init {
    double from_s = 0;  // master time since which the output has been silent
};
struct Quiet {
    double from_s = 0;    // as of Init; windows from before it do not count
    bool judged = false;  // the newest window was, without a finding
};
struct Idle {
    bool ended = false;  // the one run is over
};
struct Armed {};
struct Identify {};
struct LoopCheck {
    safety::LoopCheck loop;
    bool over = false;     // all windows are taken
    bool resumes = false;  // the DAC ran empty; the equaliser goes on where it was
};
struct Ramp {};
/// The drive is kept at its target: it settles, then measurements follow.
struct Run {
    double from_s = 0;               // master time of the set-point
    double kept_from_s = -INFINITY;  // master time since which the drive has been at its target
    bool measuring = false;
    int left = 0;  // measurements until the drive is only kept; negative: no end
};
struct RampDown {};
struct Tripped {
    enum class Phase {
        latched,   // data from before the trip are still arriving
        silent,    // waits for clear()
        clearing,  // cleared; waits until the output has released its stop
    };
    double at_s = 0;  // master time
    Phase phase = Phase::latched;
};

using State = std::variant<Init, Quiet, Idle, Armed, Identify, LoopCheck, Ramp, Run, RampDown, Tripped>;

/// The name of a state.
inline RunState named(const State& state) noexcept { return static_cast<RunState>(state.index()); }

}  // namespace shaker::run

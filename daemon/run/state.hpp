#pragma once
// Where a run stands, and which way it may go from there.

namespace shaker::run {

enum class RunState {
    init,       // devices deliver, clocks are not known yet
    self_test,  // silent: noise, clocks and gravity are looked at
    idle,       // silent, ready
    armed,      // the drive was asked for and is within the limits
    identify,   // the response is found out at a low level
    ramp,       // the drive comes up
    run,        // the drive is kept at its target
    ramp_down,
    tripped,  // a limit was violated: silent until an operator clears it
};

/// One word: "ramp_down".
const char* name(RunState state) noexcept;
/// Whether a run in `from` may go to `to`. Any state may trip, and from there only idle follows.
bool may_follow(RunState from, RunState to) noexcept;
/// The shaker is driven, or about to be.
bool driving(RunState state) noexcept;

}  // namespace shaker::run

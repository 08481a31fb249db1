#pragma once
// The states of a run and the allowed transitions.

namespace shaker::run {

enum class RunState {
    init,        // devices deliver, clocks are not known yet
    self_test,   // silent: noise, clocks and gravity are measured
    idle,        // silent, ready
    armed,       // a drive within the limits was requested
    identify,    // the response is measured at a low level
    loop_check,  // a known response is checked at a low level
    ramp,        // the drive rises to its target
    run,         // the drive is kept at its target
    ramp_down,
    tripped,  // a limit was violated: silent until an operator clears it
    /// Silent; the recording of the last run is being completed and reduced. Only a bench on call publishes
    /// it, while its sequence is idle.
    finishing,
};
inline constexpr int run_states = static_cast<int>(RunState::finishing) + 1;

/// One word: "ramp_down".
const char* name(RunState state) noexcept;
/// Whether a run in `from` may go to `to`. Any state may trip. From there idle follows, or init while the
/// self-test has not been passed.
bool may_follow(RunState from, RunState to) noexcept;
/// True when the shaker is driven: identify, loop_check, ramp, run, ramp_down.
bool driving(RunState state) noexcept;

}  // namespace shaker::run

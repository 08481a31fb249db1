#pragma once
// The states of a run: what is true in each, and the allowed transitions.
#include <array>
#include <cstddef>

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

struct StateRow {
    RunState state;
    const char* word;   // for the log, recordings, SCPI and /metrics
    const char* shown;  // for the page and shakerctl; "settling" until a run measures
    bool ready;         // the self-test has been passed
    bool driving;       // the shaker is driven
    bool settling;      // the drive is on the way to another level
    bool pending;       // passes by itself; idle, run and tripped wait for an order
};
inline constexpr std::array<StateRow, run_states> state_rows{{
    // state, word, shown, ready, driving, settling, pending
    {RunState::init, "init", "starting", false, false, false, true},
    {RunState::self_test, "self_test", "starting", false, false, false, true},
    {RunState::idle, "idle", "idle", true, false, false, false},
    {RunState::armed, "armed", "armed", true, false, false, true},
    {RunState::identify, "identify", "identifying", true, true, false, true},
    {RunState::loop_check, "loop_check", "checking", true, true, true, true},
    {RunState::ramp, "ramp", "ramping", true, true, true, true},
    {RunState::run, "run", "running", true, true, false, false},
    {RunState::ramp_down, "ramp_down", "stopping", true, true, true, true},
    {RunState::tripped, "tripped", "tripped", true, false, false, false},
    {RunState::finishing, "finishing", "finishing", true, false, false, true},
}};
constexpr const StateRow& row_of(RunState state) noexcept {
    return state_rows[static_cast<std::size_t>(state)];
}
/// One word: "ramp_down".
constexpr const char* name(RunState state) noexcept { return row_of(state).word; }
/// True when the shaker is driven: identify, loop_check, ramp, run, ramp_down.
constexpr bool driving(RunState state) noexcept { return row_of(state).driving; }

/// Whether a run in `from` may go to `to`. Any state may trip. From there idle follows, or init while the
/// self-test has not been passed.
bool may_follow(RunState from, RunState to) noexcept;

}  // namespace shaker::run

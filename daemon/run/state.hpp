#pragma once
// The states of a run: what is true in each, the allowed transitions, and the data that only one state needs.
#include <array>
#include <cmath>
#include <cstddef>
#include <variant>

#include "daemon/safety/loop_check.hpp"

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

struct Init {
    double from_s = 0;  // master time since which the output has been silent
};
struct Quiet {
    double from_s = 0;    // as of Init; windows from before it do not count
    bool judged = false;  // the newest window was, without a finding
    bool waits = false;   // for the sensor's constant part; said once
    bool mains_sought = false;
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

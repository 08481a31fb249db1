#pragma once
// Faults of drive and sensors, the state of a run in which they start, and the required reaction.
#include <array>
#include <limits>
#include <set>
#include <string>
#include <vector>

#include "tests/support/run/virtual_run.hpp"

namespace shaker::test {

/// Required reaction to a fault.
struct Answer {
    enum Kind {
        trip,           // trip with one of the causes, silent in time
        trip_or_go_on,  // trip as above, or normal end of the run: the fault does no harm
        go_on,          // no trip, normal end of the run
        never_drive,    // the drive never starts
    } kind = go_on;
    std::set<safety::Cause> causes{};
    /// After the fault, or the beginning of the drive where that is later; 0: before.
    double silent_within_s = 0;
};

/// The states of a run with a duration. Idle and armed are left at once; their faults appear in identify.
inline constexpr std::array lasting_states{run::RunState::init,     run::RunState::self_test,
                                           run::RunState::identify, run::RunState::ramp,
                                           run::RunState::run,      run::RunState::ramp_down};

struct FaultCase {
    std::string name;
    std::string toml;         // table [[fault]] of a scene, without its time
    std::string requirement;  // number in the safety table: "SAFE-6"
    std::array<Answer, lasting_states.size()> answers;
    std::set<safety::Cause> off{};  // detectors that are switched off
    std::uint64_t missing = 0;      // least number of missing samples counted, if the run goes on
    bool one_axis = false;          // the bench has a sensor with one axis, AC-coupled, without gravity
};

const std::vector<FaultCase>& fault_cases();
/// Faults that the sensor shows otherwise when it has one axis and no gravity.
const std::vector<FaultCase>& one_axis_cases();
const Answer& answer_to(const FaultCase& fault, run::RunState state);

/// A run with a fault.
struct Injected {
    double from_s = 0;  // time of the fault or start of the drive, whichever is later
    VirtualRun run;
    /// Time from from_s to the first sample of the ramp to zero, and to the last sample that is not zero.
    [[nodiscard]] double to_ramp_s() const { return run.stop_began_s - from_s; }
    [[nodiscard]] double to_silence_s() const { return run.silent_s - from_s; }
};

/// Runs with the fault starting in this state. The seed determines noise and time of the fault (odd fractions
/// of a period).
Injected inject(const FaultCase& fault, run::RunState state, int seed);

/// Differences from the required reaction, as text; empty if there are none.
std::string complaint(const FaultCase& fault, run::RunState state, const Injected& injected);

/// A sensor that delivers every sample within 0.3 ms, and a base that exceeds its limit of acceleration: time
/// from the violating sample to the first sample of the ramp, and to silence.
struct Crossing {
    double to_ramp_s = 0, to_silence_s = 0;
};
inline constexpr double limit_to_ramp_s = 0.006;      // a block of the output and 1 ms
inline constexpr double limit_to_silence_s = 0.0112;  // and the ramp of a hard stop
Crossing cross_limit(int seed);

}  // namespace shaker::test

#pragma once
// A whole run on the simulated bench in virtual time, without cameras: sequence, loops and guards as in the
// program, about a thousand times faster than real time.
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "daemon/acquisition/run_loops.hpp"
#include "daemon/run/sequence.hpp"
#include "drivers/simulated/scene.hpp"

namespace shaker::test {

struct VirtualRunSettings {
    std::string scene;  // TOML
    Drive drive{};
    int periods = 20;
    bool identify = true;
    safety::Detectors detectors = safety::all_detectors;
    std::function<void(safety::Limits&)> limits{};     // changes those of the scene's data sheets
    std::function<void(AccelerometerInfo&)> stated{};  // changes the stated properties of the accelerometer
    double stalls_at_s = std::numeric_limits<double>::infinity();  // the reduction stops from here on
    double stalls_for_s = 0;
    double line_hz = 0;  // mains, fitted beside the harmonics
    std::function<void(run::Sequence&, acquisition::Channels&, double now_s)>
        each{};  // after each block of the output
    double longest_s = 60;
};

struct VirtualRun {
    run::RunState ended = run::RunState::init;
    std::optional<safety::Trip> trip;
    std::vector<std::string> notes;
    std::map<run::RunState, double> entered_s;       // first time
    run::RunState tripped_in = run::RunState::init;  // the state before
    double dac_rate_hz = 0;
    double stop_began_s = 0;  // of the ramp to zero, on the DAC's clock; 0: there was none
    double silent_s = 0;      // last sample that was not zero
    double largest_V = 0;
    std::map<safety::Cause, std::uint64_t> warnings;

    /// Time of the sample that violated the limit, s; only for a trip on the DAC's clock.
    [[nodiscard]] double violated_s() const { return static_cast<double>(trip->tick) / dac_rate_hz; }
};

/// Limits by the data sheets of the scene.
safety::Limits limits_of(const simulated::Scene& scene);
VirtualRun run_virtually(const VirtualRunSettings& settings);

}  // namespace shaker::test

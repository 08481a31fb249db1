#pragma once
// A whole run on the simulated bench in virtual time, without its cameras: director, loops and guards as in
// the program, some thousand times faster than real time.
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "daemon/director.hpp"
#include "daemon/drive_rig.hpp"
#include "drivers/simulated/scene.hpp"

namespace shaker::test {

struct VirtualRunSettings {
    std::string scene;  // TOML
    Drive drive{};
    int periods = 20;
    bool identify = true;
    Detectors detectors = all_detectors;
    std::function<void(Limits&)> limits{};           // changes those of the scene's data sheets
    std::function<void(AccelerometerInfo&)> told{};  // changes what the accelerometer says of itself
    double stalls_at_s = std::numeric_limits<double>::infinity();  // the reduction stands still from here
    double stalls_for_s = 0;
    double line_hz = 0;                                           // mains, fitted beside the harmonics
    std::function<void(Director&, Lanes&, double now_s)> each{};  // after each block of the output
    double longest_s = 60;
};

struct VirtualRun {
    RunState ended = RunState::init;
    std::optional<Trip> trip;
    std::vector<std::string> notes;
    std::map<RunState, double> entered_s;  // first time
    RunState tripped_in = RunState::init;  // the state before
    double dac_rate_hz = 0;
    double stop_began_s = 0;  // of the ramp to zero, on the DAC's clock; 0: there was none
    double silent_s = 0;      // last sample that was not zero
    double largest_V = 0;
    std::map<Cause, std::uint64_t> warnings;

    /// When the sample was heard or taken that violated, s; only of a trip on the DAC's clock.
    [[nodiscard]] double violated_s() const { return static_cast<double>(trip->tick) / dac_rate_hz; }
};

/// Limits of what the scene's data sheets allow.
Limits limits_of(const Scene& scene);
VirtualRun run_virtually(const VirtualRunSettings& settings);

}  // namespace shaker::test

#pragma once
// A whole run on the simulated bench in virtual time, without its cameras: director, loops and guards as in
// the program, some thousand times faster than real time.
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "daemon/director.hpp"
#include "daemon/drive_rig.hpp"

namespace shaker::test {

struct VirtualRunSettings {
    std::string scene;  // TOML
    Drive drive{};
    int periods = 20;
    bool identify = true;
    Detectors detectors = all_detectors;
    std::function<void(Director&, Lanes&, double now_s)> each{};  // after each block of the output
    double longest_s = 60;
};

struct VirtualRun {
    RunState ended = RunState::init;
    std::optional<Trip> trip;
    std::vector<std::string> notes;
    std::map<RunState, double> entered_s;  // first time
    double stop_began_s = 0;               // of the ramp to zero, on the DAC's clock; 0: there was none
    double silent_s = 0;                   // last sample that was not zero
    double largest_V = 0;
    std::map<Cause, std::uint64_t> warnings;
    Drive measured{};  // by the last window
};

VirtualRun run_virtually(const VirtualRunSettings& settings);

}  // namespace shaker::test

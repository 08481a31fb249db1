#pragma once
// What the bench is at as the page and scripts read it: JSON, SI units in the keys, null where nothing is
// known.
#include <string>

#include "daemon/bench_state.hpp"
#include "daemon/desk.hpp"

namespace shaker::web {

/// Who looks, who may order, and what the viewer has been told already.
struct Viewer {
    std::string controller;     // empty: nobody
    bool controls = false;      // the viewer is that one
    bool knows_points = false;  // "points" is left out
};

/// {"type":"state","session":...,"drive":...,"measured":...,"result":...,"walker":...,"points":...,"clocks":...,
/// "losses":...,"disk":...,"limits":...}
std::string state_json(const BenchState& state, const Viewer& viewer);
/// results_json() of the newest measurement, and its averaged period:
/// {"cycle":{"phase":[...],"x_m":[...],...}}.
std::string result_json(const Reduction& reduction);
/// {"type":"event","t_s":...,"kind":...,"text":...}
std::string event_json(const BenchEvent& event);
/// The state in one word, as the page has it: "ramping".
const char* word_of(const BenchState& state) noexcept;

}  // namespace shaker::web

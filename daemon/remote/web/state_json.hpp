#pragma once
// State of the bench for the page and scripts: JSON, SI units in the keys, null for unknown values.
#include <string>

#include "daemon/service/bench_port.hpp"
#include "daemon/service/bench_state.hpp"

namespace shaker::web {

/// Properties of the viewer that change the state sent to it.
struct Viewer {
    std::string controller;     // empty: nobody
    bool controls = false;      // the viewer is the controller
    bool knows_points = false;  // "points" is omitted
};

/// {"type":"state","session":...,"drive":...,"measured":...,"result":...,"walker":...,"points":...,"clocks":...,
/// "losses":...,"disk":...,"limits":...}
std::string state_json(const service::BenchState& state, const Viewer& viewer);
/// results_json() of the newest measurement, which must exist, with its origin
/// {"measurement":{"number":...,"from_s":...,"to_s":...,"drive":{...},"current":...}} and its averaged period
/// {"cycle":{"phase":[...],"x_m":[...],...}}.
std::string result_json(const service::BenchState& state);
/// {"type":"event","t_s":...,"kind":...,"text":...}
/// now_s: master time, for the age of the event.
std::string event_json(const service::BenchEvent& event, double now_s);
/// The state in one word, as on the page: "ramping".
const char* word_of(const service::BenchState& state) noexcept;

}  // namespace shaker::web

#pragma once
// State of the bench for the page and scripts: JSON, SI units in the keys, null for unknown values.
#include <array>
#include <memory>
#include <string>

#include "daemon/remote/access/server_clock.hpp"
#include "daemon/service/bench_port.hpp"
#include "daemon/service/bench_state.hpp"

namespace shaker::web {

/// Properties of the viewer that change the state sent to it.
struct Viewer {
    std::string controller;     // empty: nobody
    bool controls = false;      // the viewer is the controller
    bool knows_points = false;  // "points" is omitted
    std::string daemon{};       // Site::daemon
};

/// {"type":"state","session":...,"drive":...,"measured":...,"result":...,"walker":...,"points":...,"clocks":...,
/// "losses":...,"disk":...,"limits":...}
std::string state_json(const service::BenchState& state, const Viewer& viewer);
/// Texts of the state that all sockets share: with many pages the server's thread makes as few as with two.
class StateTexts {
public:
    /// state_json() of this state, or of one that is at most 33 ms older and has the same run state, result
    /// and answered orders.
    std::shared_ptr<const std::string> of(const std::shared_ptr<const service::BenchState>& state,
                                          const Viewer& viewer);

private:
    struct Made {
        std::shared_ptr<const service::BenchState> of;
        std::string controller;
        access::ServerClock::time_point at{};
        std::shared_ptr<const std::string> text;
    };
    std::array<Made, 4> made_;  // by Viewer::controls and Viewer::knows_points
};

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

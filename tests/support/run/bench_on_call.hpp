#pragma once
// The simulated bench on call, in lockstep on virtual time, with the steps of an operator.
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "daemon/service/bench_service.hpp"

namespace shaker::test {

/// Cameras with a fifth of the rendering time.
inline constexpr const char* slow = "[top]\nframe_rate_hz = 200\n[side]\nframe_rate_hz = 200\n";
/// Short measurements without pictures.
run::RunOptions quick();

/// One action of the operator, with the state in which it starts.
struct Move {
    std::function<bool(const service::BenchState&)> when;
    std::function<void(service::BenchPort&)> act;
};

/// Answers to the orders, in their order; "" means done.
using Answers = std::vector<std::string>;

/// Sends an order and stores the answer.
std::function<void(service::BenchPort&)> orders(service::OrderWhat what, Answers& answers);
/// True in this state once every order has been answered.
std::function<bool(const service::BenchState&)> in(run::RunState state);

struct OnCallResult {
    service::BenchState last;  // the last published state
    std::vector<service::BenchEvent> events;
    double virtual_s = 0;
};

/// The events, one line each.
std::string log_of(const OnCallResult& result);

/// Plays all moves, then ends. After `limit_s` of virtual time it reports the remaining moves as a failure of
/// the test and ends. mu: friction in the settings of the daemon.
OnCallResult play_on_call(const std::string& scene, const run::RunOptions& run,
                          const std::filesystem::path& folder, std::vector<Move> moves, double limit_s = 60,
                          calibration::Estimate mu = {});

}  // namespace shaker::test

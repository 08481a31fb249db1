#pragma once
// The simulated bench on call, in lockstep on virtual time, with what an operator does step by step.
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "daemon/session.hpp"

namespace shaker::test {

/// One thing the operator does, as soon as the state is what he waits for.
struct Move {
    std::function<bool(const BenchState&)> when;
    std::function<void(Desk&)> act;
};

/// What an order was answered with, in the order of asking; "" when it was done.
using Answers = std::vector<std::string>;

/// Orders and notes the answer.
std::function<void(Desk&)> orders(OrderWhat what, Answers& answers);
/// In this state, and every order was answered.
std::function<bool(const BenchState&)> in(RunState state);

struct OnCallResult {
    BenchState last;  // that was published
    std::vector<BenchEvent> events;
    double virtual_s = 0;
};

/// Plays all moves, then leaves. `limit_s` of virtual time: beyond it the moves that are left are told as a
/// failure of the test, and it leaves. mu: as the settings of a daemon may have it.
OnCallResult play_on_call(const std::string& scene, const RunOptions& run,
                          const std::filesystem::path& folder, std::vector<Move> moves, double limit_s = 60,
                          Estimate mu = {});

}  // namespace shaker::test

#pragma once
// The simulated bench on call, in lockstep on virtual time, with the steps of an operator.
#include <gtest/gtest.h>

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "daemon/service/bench_service.hpp"
#include "tests/support/program.hpp"

namespace shaker::test {

/// Cameras that give 200 positions a second instead of pictures: nothing is rendered or tracked.
inline constexpr const char* slow =
    "[top]\npositions = 1\nframe_rate_hz = 200\n[side]\npositions = 1\nframe_rate_hz = 200\n";
/// Cameras with 200 pictures a second, for tests of pictures or of their tracking.
inline constexpr const char* rendered = "[top]\nframe_rate_hz = 200\n[side]\nframe_rate_hz = 200\n";
/// Short measurements without pictures.
run::RunOptions quick();

/// One action of the operator, with the state in which it starts.
struct Move {
    std::function<bool(const service::BenchState&)> when;
    std::function<void(service::BenchPort&)> act;
    bool leaves = false;  // before `act` the program is ordered to end
};

/// Answers to the orders, in their order; "" means done.
using Answers = std::vector<std::string>;

/// Sends an order and stores the answer.
std::function<void(service::BenchPort&)> orders(service::OrderWhat what, Answers& answers);
/// True in this state once every order has been answered.
std::function<bool(const service::BenchState&)> in(run::RunState state);

/// True from this master time on, s.
std::function<bool(const service::BenchState&)> from_s(double t_s);
/// True with this number of measured points.
std::function<bool(const service::BenchState&)> measured(std::size_t points);
/// True when a trip can be cleared.
bool may_clear(const service::BenchState& state);
/// Waits; no order follows.
Move until(std::function<bool(const service::BenchState&)> when);

/// A table [[fault]] of a scene. more: further lines.
std::string fault(const std::string& what, double at_s, const std::string& more = {});

struct OnCallResult {
    service::BenchState last;  // the last published state
    std::vector<service::BenchEvent> events;
    double virtual_s = 0;
};

/// The events, one line each.
std::string log_of(const OnCallResult& result);
/// Master times at which the bench entered a state, s.
std::vector<double> entered(const OnCallResult& result, run::RunState state);

/// Plays all moves, then ends (unless a move has ordered that). After `limit_s` of virtual time it reports
/// the remaining moves as a failure of the test and ends. mu: friction in the settings of the daemon.
OnCallResult play_on_call(const std::string& scene, const run::RunOptions& run,
                          const std::filesystem::path& folder, std::vector<Move> moves, double limit_s = 60,
                          calibration::Estimate mu = {});

/// A bench in a folder of its own, and an operator whose orders are answered in `answers`.
class OnCallBench : public testing::Test {
protected:
    [[nodiscard]] std::function<void(service::BenchPort&)> give(service::OrderWhat what) {
        return orders(std::move(what), answers);
    }
    /// From idle: drives and measures ten periods repeatedly.
    [[nodiscard]] Move start() { return {in(run::RunState::idle), give(service::Begin{{.periods = 10}})}; }
    /// As play_on_call(); clears the answers first.
    OnCallResult play(const std::string& scene, std::vector<Move> moves, double limit_s = 60,
                      calibration::Estimate mu = {}) {
        answers.clear();
        return play_on_call(scene, options, folder, std::move(moves), limit_s, mu);
    }

    const std::filesystem::path folder = fresh_folder();
    run::RunOptions options = quick();
    Answers answers;
};

}  // namespace shaker::test

#include "tests/support/run/bench_on_call.hpp"

#include <spdlog/fmt/fmt.h>

#include <fstream>

#include "daemon/run/runner.hpp"

namespace shaker::test {

run::RunOptions quick() {
    run::RunOptions run;
    run.pictures = recorded::KeptPictures::off;
    run.plan.periods = 10;
    return run;
}

std::function<void(service::BenchPort&)> orders(service::OrderWhat what, Answers& answers) {
    return [what = std::move(what), &answers](service::BenchPort& bench_port) {
        bench_port.order({what, [&answers](const std::string& refused) { answers.push_back(refused); }});
    };
}

std::function<bool(const service::BenchState&)> in(run::RunState state) {
    return [state](const service::BenchState& s) { return s.state == state; };
}

std::function<bool(const service::BenchState&)> from_s(double t_s) {
    return [t_s](const service::BenchState& s) { return s.now_s >= t_s; };
}

std::function<bool(const service::BenchState&)> measured(std::size_t points) {
    return [points](const service::BenchState& s) { return s.points.size() >= points; };
}

bool may_clear(const service::BenchState& state) { return state.may_clear; }

Move until(std::function<bool(const service::BenchState&)> when) {
    return {std::move(when), [](service::BenchPort&) {}};
}

std::string fault(const std::string& what, double at_s, const std::string& more) {
    return fmt::format("[[fault]]\nwhat = \"{}\"\nat_s = {}\n{}", what, at_s, more);
}

std::vector<double> entered(const OnCallResult& result, run::RunState state) {
    std::vector<double> times;
    for (const service::BenchEvent& e : result.events)
        if (e.kind == "state" && e.text == name(state)) times.push_back(e.t_s);
    return times;
}

std::string log_of(const OnCallResult& result) {
    std::string all;
    for (const service::BenchEvent& e : result.events)
        all += fmt::format("{:.3f} s {}: {}\n", e.t_s, e.kind, e.text);
    return all;
}

OnCallResult play_on_call(const std::string& scene, const run::RunOptions& run,
                          const std::filesystem::path& folder, std::vector<Move> moves, double limit_s,
                          calibration::Estimate mu) {
    std::filesystem::path file;
    if (!scene.empty()) {
        file = folder / "scene.toml";
        std::ofstream{file} << scene;
    }
    run::RunOptions options = run;
    options.scene = file;
    run::Runner runner{{.run = options, .on_call = true, .recordings = folder}};
    service::BenchPort bench_port;
    service::BenchService session{runner, {.mu = mu}, bench_port};
    OnCallResult result;
    std::size_t move = 0;
    std::shared_ptr<const service::BenchState> seen;
    runner.lead(
        [&](const acquisition::Streams& streams, acquisition::Channels& channels) {
            const bool any = session.step(streams, channels);
            const auto state = bench_port.state();
            if (state == seen) return any;
            seen = state;
            result.last = *state;
            result.last.pictures_now.clear();  // they hold buffers of the cameras
            const bool late = state->now_s > limit_s;
            if (late && move < moves.size()) {
                ADD_FAILURE() << "move " << move << " was not possible in " << limit_s << " s; state "
                              << name(state->state);
                move = moves.size();
            }
            if (state->answered < bench_port.ordered()) return any;
            if (move < moves.size() && moves[move].when(*state)) {
                if (moves[move].leaves) session.leave();
                moves[move++].act(bench_port);
            } else if (move == moves.size() && !session.leaving()) {
                session.leave();
            }
            return any;
        },
        [&] { return session.done(); });
    result.events = bench_port.events(0);
    result.virtual_s = runner.played_s();
    return result;
}

}  // namespace shaker::test

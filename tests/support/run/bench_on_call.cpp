#include "tests/support/run/bench_on_call.hpp"

#include <gtest/gtest.h>
#include <spdlog/fmt/fmt.h>

#include <fstream>

#include "daemon/run/runner.hpp"

namespace shaker::test {

run::RunOptions quick() {
    run::RunOptions run;
    run.pictures = recorded::KeptPictures::off;
    run.periods = 10;
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
            if (move < moves.size() && moves[move].when(*state))
                moves[move++].act(bench_port);
            else if (move == moves.size() && !session.leaving())
                session.leave();
            return any;
        },
        [&] { return session.done(); });
    result.events = bench_port.events(0);
    result.virtual_s = runner.played_s();
    return result;
}

}  // namespace shaker::test

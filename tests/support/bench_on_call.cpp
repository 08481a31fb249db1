#include "tests/support/bench_on_call.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "daemon/drive_rig.hpp"
#include "drivers/region_camera.hpp"

namespace shaker::test {

std::function<void(Desk&)> orders(OrderWhat what, Answers& answers) {
    return [what = std::move(what), &answers](Desk& desk) {
        desk.order({what, [&answers](const std::string& refused) { answers.push_back(refused); }});
    };
}

std::function<bool(const BenchState&)> in(RunState state) {
    return [state](const BenchState& s) { return s.state == state; };
}

OnCallResult play_on_call(const std::string& scene, const RunOptions& run,
                          const std::filesystem::path& folder, std::vector<Move> moves, double limit_s,
                          Estimate mu) {
    std::filesystem::path file;
    if (!scene.empty()) {
        file = folder / "scene.toml";
        std::ofstream{file} << scene;
    }
    OpenRig bench = open_rig("sim:", file, World::Pace::lockstep);
    if (run.pictures == KeptPictures::region) take_regions(bench.rig);
    const Limits limits = limits_on_call(bench.limits);
    Acquisition acquisition{bench.rig, nullptr, limits, run.drive.frequency};
    const DacInfo dac = bench.rig.dac->info();
    Output output{dac,
                  run.drive.frequency,
                  trigger_rate(bench.rig),
                  dac.block_frames,
                  limits,
                  bench.rig.accelerometer->info().rate_hz};
    Desk desk;
    Session session{bench, acquisition, {.run = run, .record = {.folder = folder}, .mu = mu}, desk};
    OnCallResult result;
    std::size_t move = 0;
    std::shared_ptr<const BenchState> seen;
    static_cast<void>(drive_rig(
        bench, acquisition, output, false,
        [&](const Take& take, Lanes& lanes) {
            const bool any = session.step(take, lanes);
            const auto state = desk.state();
            if (state == seen) return any;
            seen = state;
            result.last = *state;
            result.last.pictures_now.clear();  // they hold the cameras' buffers
            const bool late = state->now_s > limit_s;
            if (late && move < moves.size()) {
                ADD_FAILURE() << "move " << move << " was not possible in " << limit_s << " s; state "
                              << name(state->state);
                move = moves.size();
            }
            if (state->answered < desk.ordered()) return any;
            if (move < moves.size() && moves[move].when(*state))
                moves[move++].act(desk);
            else if (move == moves.size())
                session.leave();
            return any;
        },
        [&] { return session.done(); }));
    result.events = desk.events(0);
    result.virtual_s = static_cast<double>(output.synthesiser.tick().n) / dac.rate_hz;
    return result;
}

}  // namespace shaker::test

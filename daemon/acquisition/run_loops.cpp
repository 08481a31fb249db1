#include "daemon/acquisition/run_loops.hpp"

#include <spdlog/fmt/fmt.h>

#include "drivers/errors.hpp"
#include "drivers/ticks.hpp"

namespace shaker::acquisition {

namespace {

constexpr double most_lead_s =
    0.1;  // largest lead of a simulated rig's output over the reduction, with threads

}  // namespace

double trigger_rate(const Rig& rig) {
    const View* first = nullptr;
    for (const auto& camera : rig.cameras) {
        const View& view = camera->view();
        if (!view.dac_triggered) continue;
        if (first == nullptr) first = &view;
        if (view.frame_rate_hz != first->frame_rate_hz)
            throw InputError{
                fmt::format("camera \"{}\": frame_rate_hz = {} differs from {} of camera \"{}\"; one trigger "
                            "serves all cameras",
                            view.camera, view.frame_rate_hz, first->frame_rate_hz, first->camera)};
    }
    return first == nullptr ? 0 : first->frame_rate_hz;
}

bool runs_threaded(const bench::Bench& bench, bool threads) { return threads || bench.world == nullptr; }

Execution run_loops(bench::Bench& bench, Collector& collector, DriveOutput& output, bool threads,
                    const Lead& lead, const std::function<bool()>& done,
                    const std::function<bool()>& recorder) {
    Rig& rig = bench.rig;
    const bool simulated = bench.world != nullptr;
    // Hardware keeps to real time. Virtual time waits for the reduction, which shares the processor.
    const auto ahead = static_cast<std::int64_t>(most_lead_s * rig.dac->info().rate_hz);
    const bool wait_for_reduction = simulated && threads;
    const bool real_time = runs_threaded(bench, threads);
    const double block_s = duration_s(std::ssize(output.volts), rig.dac->info().rate_hz);
    std::vector<Loop> loops{
        {"output", 70, !wait_for_reduction, [&](std::chrono::milliseconds) {
             if (wait_for_reduction && output.synthesiser.tick().n - collector.channels().gathered > ahead)
                 return false;
             output_step(output, *rig.dac, collector.channels());
             if (real_time) collector.channels().jitter.took(std::chrono::steady_clock::now(), block_s);
             return true;
         }}};
    for (Loop& loop : collector.sensor_loops()) loops.push_back(std::move(loop));
    if (recorder)
        loops.push_back({"recorder", 20, false, [&](std::chrono::milliseconds) { return recorder(); }});
    loops.push_back({"reduction", 0, false, [&](std::chrono::milliseconds) {
                         const bool any = collector.collect();
                         return lead(collector.streams(), collector.channels()) || any;
                     }});
    const auto unblock = [&] {
        rig.dac->stop();
        if (rig.accelerometer) rig.accelerometer->stop();
        for (const auto& camera : rig.cameras) camera->stop();
    };
    Execution execution = real_time ? run_threaded(loops, done, unblock) : run_lockstep(loops, done);
    collector.collect();
    return execution;
}

}  // namespace shaker::acquisition

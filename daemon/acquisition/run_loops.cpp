#include "daemon/acquisition/run_loops.hpp"

#include <spdlog/fmt/fmt.h>

#include "drivers/errors.hpp"
#include "drivers/realtime.hpp"
#include "drivers/time.hpp"

namespace shaker::acquisition {

namespace {

// Largest lead of a simulated rig's output over the reduction, with threads.
constexpr double most_lead_s = 0.1;
// Pauses at rest, when a wake costs more than its work. The recorder's rings hold seconds.
constexpr std::chrono::milliseconds reduction_pause{2}, recorder_pause{4};
constexpr double played_out_s = 0.25;  // silence after the ramp, so that a DAC has played its buffer

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
    const double own_hz = rig.dac ? rig.dac->info().pulse_hz : 0;
    if (first == nullptr) return own_hz;
    if (own_hz > 0 && own_hz != first->frame_rate_hz)
        throw InputError{
            fmt::format("camera \"{}\": frame_rate_hz = {} differs from pulse_hz = {} of the DAC; one "
                        "trigger serves all cameras",
                        first->camera, first->frame_rate_hz, own_hz)};
    return first->frame_rate_hz;
}

bool runs_threaded(const bench::Bench& bench, bool threads) { return threads || bench.world == nullptr; }

namespace {

safety::Cause cause_of(const std::string& loop) {
    if (loop == "accelerometer") return safety::Cause::sensor_missing;
    return loop.starts_with("camera") ? safety::Cause::camera_missing : safety::Cause::watchdog;
}

// The output stops for the failed loop. True when the drive has been silent for a while, or cannot be stopped
// because the output itself has failed.
bool wound_down(const Loop& failed, const DriveOutput& output, double rate_hz, Channels& channels) {
    if (failed.name == "output") return true;
    channels.failed = static_cast<int>(cause_of(failed.name));
    return duration_s(channels.silent, rate_hz) > played_out_s + output.guard.longest_stop_s();
}

}  // namespace

double run_loops(bench::Bench& bench, Collector& collector, DriveOutput& output, bool threads,
                 const Leader& leader) {
    Rig& rig = bench.rig;
    Channels& channels = collector.channels();
    output.has_contact = rig.abort_input != nullptr;
    const bool simulated = bench.world != nullptr;
    const double rate_hz = rig.dac->info().rate_hz;
    // Hardware keeps to real time. Virtual time waits for the reduction, which shares the processor.
    const auto ahead = static_cast<std::int64_t>(most_lead_s * rate_hz);
    const bool wait_for_reduction = simulated && threads;
    const bool real_time = runs_threaded(bench, threads);
    const double block_s = duration_s(std::ssize(output.volts), rate_hz);
    std::vector<Loop> loops{
        {"output", fifo_priority::output, !wait_for_reduction, [&](std::chrono::milliseconds) {
             if (wait_for_reduction && channels.failed < 0 &&
                 output.synthesiser.tick().n - channels.gathered > ahead)
                 return false;
             output_step(output, *rig.dac, channels);
             if (real_time) channels.jitter.took(std::chrono::steady_clock::now(), block_s);
             return true;
         }}};
    if (rig.abort_input)
        loops.push_back(
            {"abort input", fifo_priority::abort_input, true, [&](std::chrono::milliseconds wait) {
                 abort_input_step(*rig.abort_input, wait, channels);
                 return false;
             }});
    for (Loop& loop : collector.sensor_loops()) loops.push_back(std::move(loop));
    if (leader.recorder)
        loops.push_back({.name = "recorder",
                         .fifo_priority = fifo_priority::recorder,
                         .waits = false,
                         .step = [&](std::chrono::milliseconds) { return leader.recorder(); },
                         .pause = recorder_pause});
    loops.push_back({.name = "reduction",
                     .waits = false,
                     .step =
                         [&](std::chrono::milliseconds) {
                             const bool any = collector.collect();
                             return leader.lead(collector.streams(), channels) || any;
                         },
                     .pause = reduction_pause});
    if (simulated)
        for (Loop& loop : loops) loop.fifo_priority = 0;
    const auto unblock = [&] {
        rig.dac->stop();
        if (rig.accelerometer) rig.accelerometer->stop();
        for (const auto& camera : rig.cameras) camera->stop();
    };
    const RunHooks hooks{leader.begun,
                         [&](std::size_t i) { return wound_down(loops[i], output, rate_hz, channels); }};
    try {
        const double wall_s = real_time ? run_threaded(loops, leader.done, unblock, hooks)
                                        : run_lockstep(loops, leader.done, hooks);
        collector.collect();
        return wall_s;
    } catch (...) {
        collector.collect();  // the ramp to zero belongs to the run
        throw;
    }
}

}  // namespace shaker::acquisition

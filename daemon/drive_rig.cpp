#include "daemon/drive_rig.hpp"

#include <spdlog/fmt/fmt.h>

#include "drivers/errors.hpp"

namespace shaker {

namespace {

constexpr double most_lead_s = 0.1;  // of a simulated rig's output before the reduction, with threads

}  // namespace

double trigger_rate(const Rig& rig) {
    const View* first = nullptr;
    for (const auto& camera : rig.cameras) {
        const View& view = camera->view();
        if (!view.dac_triggered) continue;
        if (first == nullptr) first = &view;
        if (view.frame_rate_hz != first->frame_rate_hz)
            throw InputError{
                fmt::format("camera \"{}\": frame_rate_hz = {} is not the {} of camera \"{}\"; one trigger "
                            "serves all",
                            view.camera, view.frame_rate_hz, first->frame_rate_hz, first->camera)};
    }
    return first == nullptr ? 0 : first->frame_rate_hz;
}

bool runs_threaded(const OpenRig& bench, bool threads) { return threads || bench.world == nullptr; }

Execution drive_rig(OpenRig& bench, Acquisition& acquisition, Output& output, bool threads, const Lead& lead,
                    const std::function<bool()>& done, const std::function<bool()>& recorder) {
    Rig& rig = bench.rig;
    const bool simulated = bench.world != nullptr;
    // Real time paces real hardware; virtual time must not run away from a reduction that shares the
    // processor.
    const auto ahead = static_cast<std::int64_t>(most_lead_s * rig.dac->info().rate_hz);
    const bool wait_for_reduction = simulated && threads;
    const bool real_time = runs_threaded(bench, threads);
    const double block_s = static_cast<double>(output.volts.size()) / rig.dac->info().rate_hz;
    std::vector<Loop> loops{
        {"output", 70, !wait_for_reduction, [&](std::chrono::milliseconds) {
             if (wait_for_reduction && output.synthesiser.tick().n - acquisition.lanes().gathered > ahead)
                 return false;
             output_step(output, *rig.dac, acquisition.lanes());
             if (real_time) acquisition.lanes().jitter.took(std::chrono::steady_clock::now(), block_s);
             return true;
         }}};
    for (Loop& loop : acquisition.sensor_loops()) loops.push_back(std::move(loop));
    if (recorder)
        loops.push_back({"recorder", 20, false, [&](std::chrono::milliseconds) { return recorder(); }});
    loops.push_back({"reduction", 0, false, [&](std::chrono::milliseconds) {
                         const bool any = acquisition.collect();
                         return lead(acquisition.take(), acquisition.lanes()) || any;
                     }});
    const auto unblock = [&] {
        rig.dac->stop();
        if (rig.accelerometer) rig.accelerometer->stop();
        for (const auto& camera : rig.cameras) camera->stop();
    };
    Execution execution = real_time ? run_threaded(loops, done, unblock) : run_lockstep(loops, done);
    acquisition.collect();
    return execution;
}

std::vector<DeviceReport> device_reports(const Rig& rig) {
    std::vector<DeviceReport> reports;
    if (rig.dac) reports.push_back({rig.dac->info().name, "samples", rig.dac->counts()});
    if (rig.accelerometer)
        reports.push_back({rig.accelerometer->info().name, "samples", rig.accelerometer->counts()});
    for (const auto& camera : rig.cameras)
        reports.push_back({"camera \"" + camera->view().camera + "\"", "frames", camera->counts()});
    return reports;
}

}  // namespace shaker

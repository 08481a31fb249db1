#include "daemon/drive_rig.hpp"

#include <spdlog/fmt/fmt.h>

#include "drivers/errors.hpp"

namespace shaker {

namespace {

constexpr double most_lead_s = 0.1;  // of a simulated rig's output before the reduction, with threads

void note_counts(std::vector<std::string>& notes, const std::string& device, const char* what,
                 const DeviceCounts& c) {
    if (c.lost == 0 && c.incidents == 0 && c.reopened == 0) return;
    notes.push_back(fmt::format("{}: {} {} lost of {}, {} incidents, reopened {} times", device, c.lost, what,
                                c.taken + c.lost, c.incidents, c.reopened));
}

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

Execution drive_rig(OpenRig& bench, Acquisition& acquisition, Output& output, bool threads, const Lead& lead,
                    const std::function<bool()>& done) {
    Rig& rig = bench.rig;
    const bool simulated = bench.world != nullptr;
    // Real time paces real hardware; virtual time must not run away from a reduction that shares the
    // processor.
    const auto ahead = static_cast<std::int64_t>(most_lead_s * rig.dac->info().rate_hz);
    const bool wait_for_reduction = simulated && threads;
    std::vector<Loop> loops{{"output", 70, !wait_for_reduction, [&](std::chrono::milliseconds) {
                                 if (wait_for_reduction &&
                                     output.synthesiser.tick().n - acquisition.lanes().gathered > ahead)
                                     return false;
                                 output_step(output, *rig.dac, acquisition.lanes());
                                 return true;
                             }}};
    for (Loop& loop : acquisition.sensor_loops()) loops.push_back(std::move(loop));
    loops.push_back({"reduction", 0, false, [&](std::chrono::milliseconds) {
                         const bool any = acquisition.collect();
                         return lead(acquisition.take(), acquisition.lanes().drive) || any;
                     }});
    const auto unblock = [&] {
        rig.dac->stop();
        if (rig.accelerometer) rig.accelerometer->stop();
        for (const auto& camera : rig.cameras) camera->stop();
    };
    Execution execution =
        threads || !simulated ? run_threaded(loops, done, unblock) : run_lockstep(loops, done);
    acquisition.collect();
    return execution;
}

std::vector<std::string> notes_on(const Rig& rig) {
    std::vector<std::string> notes;
    if (rig.dac) note_counts(notes, rig.dac->info().name, "samples of time", rig.dac->counts());
    if (rig.accelerometer)
        note_counts(notes, rig.accelerometer->info().name, "samples", rig.accelerometer->counts());
    for (const auto& camera : rig.cameras)
        note_counts(notes, "camera \"" + camera->view().camera + "\"", "frames", camera->counts());
    return notes;
}

}  // namespace shaker

#include "daemon/run_setup.hpp"

#include <spdlog/fmt/fmt.h>

#include "daemon/recording_watch.hpp"
#include "daemon/run_settings.hpp"
#include "daemon/session_places.hpp"
#include "daemon/time_text.hpp"
#include "drivers/synthesiser.hpp"

namespace shaker {

SessionHeader run_header(const OpenRig& bench, const RunOptions& run, bool live, bool with_truth) {
    const Rig& rig = bench.rig;
    SessionHeader header;
    header.title = fmt::format("gamma {:.4g} m/s^2, phi {:.4g} rad, rho {:.4g}, {:.6g} Hz", run.drive.gamma,
                               run.drive.phi, run.drive.rho, run.drive.frequency);
    if (!run.drive.biharmonic()) header.title += " and overtones";
    header.kind = "run";
    header.config = run_settings_text(run);
    header.rig = bench.rig_text;
    header.dac = rig.dac->info();
    header.frequency_hz = Synthesiser::realised(run.drive.frequency, header.dac.rate_hz);
    header.accelerometer = rig.accelerometer->info();
    header.pictures = run.pictures;
    header.started = live ? local_time_text() : epoch_text;
    if (live) header.identifier = new_identifier();
    for (const auto& camera : rig.cameras) header.views.push_back(camera->view());
    header.groups = session_places(header, with_truth);
    return header;
}

std::vector<Demand> run_demands(const OpenRig& bench, const Drive& drive, const Limits& limits) {
    PlannedMotion plan{.target = harmonics(drive),
                       .frequency = drive.frequency,
                       .moving_kg = bench.shaker.moving_mass_kg + bench.shaker.base_mass_kg +
                                    (bench.world ? bench.scene.walker.mass_kg : 0)};
    for (std::size_t q = 0; q < max_harmonics; ++q)
        plan.response[q] = bench.response(static_cast<double>(q + 1) * drive.frequency);
    return demands(plan, limits);
}

RunPlan run_plan(const OpenRig& bench, const RunOptions& run, const Limits& limits) {
    constexpr double usable = 0.95;  // of what the drive may reach: room for corrections
    return {.keeper = {.drive = run.drive,
                       .volts_limit = usable * limits.drive.abort,
                       .identify = run.identify,
                       .equalise = run.closed_loop,
                       .sheet = bench.response},
            .line_hz = run.mains_hz,
            .periods = run.periods,
            .settle = run.settle,
            .limits = limits};
}

}  // namespace shaker

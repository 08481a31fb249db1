#include "daemon/run/run_setup.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <boost/uuid/random_generator.hpp>
#include <boost/uuid/uuid_io.hpp>
#include <cmath>

#include "daemon/control/harmonic_estimator.hpp"
#include "daemon/recording/tables/places.hpp"
#include "daemon/recording/time_text.hpp"
#include "daemon/reduction/selection.hpp"
#include "drivers/errors.hpp"
#include "drivers/settings_table.hpp"
#include "drivers/synthesiser.hpp"

namespace shaker::run {

recorded::RecordingHeader run_header(const bench::Bench& bench, const std::vector<View>& views,
                                     const RunOptions& run, bool live, bool with_truth) {
    const Rig& rig = bench.rig;
    recorded::RecordingHeader header;
    header.title = fmt::format("gamma {:.4g} m/s^2, phi {:.4g} rad, rho {:.4g}, {:.6g} Hz", run.drive.gamma,
                               run.drive.phi, run.drive.rho, run.drive.frequency);
    if (!run.drive.biharmonic()) header.title += " and overtones";
    header.kind = "run";
    header.config = run_settings_text(run);
    header.rig = bench.rig_text;
    for (const commissioned::Named& file : bench.files)
        if (file.what.starts_with(commissioned::mixer_of)) header.mixers += file.what + "\n" + file.text;
    header.dac = rig.dac->info();
    header.frequency_hz = Synthesiser::realised(run.drive.frequency, header.dac.rate_hz);
    header.accelerometer = rig.accelerometer->info();
    header.pictures = run.pictures;
    header.started = live ? recording::local_time_text() : recording::epoch_text;
    if (live) header.identifier = to_string(boost::uuids::random_generator{}());
    header.views = views;
    recording::lay_out(header, with_truth);
    return header;
}

safety::Limits limits_of_run(safety::Limits limits) {
    limits.detectors.reset(static_cast<std::size_t>(safety::Cause::underrun));
    return limits;
}

bool gain_shown(const Rig& rig) {
    if (!rig.accelerometer) return true;
    const AccelerometerInfo sensor = rig.accelerometer->info();
    return (sensor.gravity && sensor.axes == 3) || std::ranges::any_of(rig.cameras, [](const auto& camera) {
               return std::ranges::find(camera->view().targets, "base", &Target::name) !=
                      camera->view().targets.end();
           });
}

namespace {

/// By this sensor on this bench, not by a certificate.
bool measured(const SensorResponse& response) {
    return !response.file.empty() &&
           !SettingsTable::from_text(response.file, "response").text("sensor").empty();
}

}  // namespace

void require_seen(const bench::Bench& bench, const Drive& drive) {
    const AccelerometerInfo sensor = bench.rig.accelerometer->info();
    const double rate_hz = sensor.rate_hz;
    const int needed = control::least_samples(control::controlled_harmonics);
    if (drive.frequency * needed > rate_hz)
        throw InputError{fmt::format(
            "frequency {:.4g} Hz: the accelerometer has {:.1f} samples a period and {} are needed "
            "for {} harmonics; "
            "with its {:.4g} samples/s at most {:.4g} Hz is allowed",
            drive.frequency, rate_hz / drive.frequency, needed, control::controlled_harmonics, rate_hz,
            std::floor(10 * rate_hz / needed) / 10)};
    constexpr double most_moved = 0.1;
    if (measured(sensor.response)) return;
    const Harmonics<Acceleration> motion = harmonics(drive);
    for (int q = 1; q <= motion.order(); ++q) {
        const double f = q * drive.frequency, moved = std::abs(sensor.response.at(f)) - 1;
        if (motion.at(q) == 0.0 || std::abs(moved) <= most_moved) continue;
        throw InputError{
            fmt::format("frequency {:.4g} Hz: high_pass_hz or low_pass_hz of the accelerometer change the "
                        "amplitude at {:.4g} "
                        "Hz by {:+.0f} %; at most {:.0f} % is allowed for a response that was not measured "
                        "here: leave these keys out, then \"shakerd calibrate response\"",
                        drive.frequency, f, 100 * moved, 100 * most_moved)};
    }
}

void require_pictures(const Rig& rig, double frequency) {
    for (const char* target : {"walker", "base"}) {
        double most = 0;
        std::string of;
        for (const auto& camera : rig.cameras) {
            const View view = camera->view();
            if (std::ranges::find(view.targets, target, &Target::name) == view.targets.end() ||
                view.frame_rate_hz <= most)
                continue;
            most = view.frame_rate_hz;
            of = view.camera;
        }
        if (of.empty() || most >= reduction::least_frames * frequency) continue;
        throw InputError{
            fmt::format("frequency {:.4g} Hz: camera \"{}\" takes {:.2g} pictures a period of the {} and "
                        "{:.0f} are needed; "
                        "with its {:.4g} pictures/s at most {:.4g} Hz is allowed",
                        frequency, of, most / frequency, target, reduction::least_frames, most,
                        std::floor(10 * most / reduction::least_frames) / 10)};
    }
}

std::vector<safety::Demand> run_demands(const bench::Bench& bench, const Drive& drive,
                                        const safety::Limits& limits) {
    return motion_demands(bench, harmonics(drive), drive.frequency, limits);
}

std::vector<safety::Demand> motion_demands(const bench::Bench& bench, const Harmonics<Acceleration>& motion,
                                           double frequency, const safety::Limits& limits) {
    safety::PlannedMotion plan{.target = motion,
                               .frequency = frequency,
                               .moving_kg = bench.shaker.moving_mass_kg + bench.shaker.base_mass_kg +
                                            (bench.world ? bench.scene.walker.mass_kg : 0)};
    for (std::size_t q = 0; q < max_harmonics; ++q)
        plan.response[q] = bench.response(static_cast<double>(q + 1) * frequency);
    return demands(plan, limits);
}

RunPlan run_plan(const bench::Bench& bench, const RunOptions& run, const safety::Limits& limits) {
    return {.controller = {.drive = run.drive,
                           .volts_limit = usable_drive * limits.drive.abort,
                           .identify = run.identify,
                           .equalise = run.closed_loop,
                           .sheet = bench.response},
            .line_hz = run.mains_hz,
            .task = {.plan = run.plan},
            .limits = limits,
            .gravity = bench.gravity,
            .gain_shown = gain_shown(bench.rig),
            .enable_before_s = bench.rig.dac->info().enable_before_s,
            .walk = predict_walk(run.drive, {}, run.mu, bench.gravity)};
}

}  // namespace shaker::run

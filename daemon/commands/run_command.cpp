#include "daemon/commands/run_command.hpp"

#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>

#include <cmath>
#include <cstdio>
#include <exception>
#include <numbers>

#include "daemon/commands/stop_signals.hpp"
#include "daemon/report/printing.hpp"
#include "daemon/report/results.hpp"
#include "daemon/run/runner.hpp"
#include "drivers/errors.hpp"
#include "drivers/walker/steady_state.hpp"

namespace shaker::commands {

namespace {

Harmonics<Acceleration> measured_base(const reduction::Reduction& r) {
    Harmonics<Acceleration> base;
    for (const reduction::MeasuredHarmonic& h : r.harmonics)
        if (h.q <= max_harmonics) base.at(h.q) = std::polar(h.amplitude.value, h.phase.value);
    return base;
}

// Drift velocity for a motion of the base with exact Coulomb friction and the scene's coefficients, m/s.
double coulomb_drift(const Harmonics<Acceleration>& base, double frequency, const simulated::Scene& scene) {
    walker::WalkerSetting setting;
    setting.frequency = frequency;
    setting.base = base;
    setting.tilt = scene.tilt_deg * std::numbers::pi / 180;
    setting.g = scene.gravity;
    setting.friction = {scene.walker.mu_k, scene.walker.mu_s, 0};
    return settle(walker::WalkerLaw{setting}).v_D;
}

struct Speed {
    double wall_s, virtual_s, render_s;
};

void print_truth(const reduction::Reduction& r, double v_D, const Drive& asked, const simulated::Scene& scene,
                 const Speed& speed) {
    fmt::print("comparison with the simulated truth:\n  {:<22}{:>24} mm/s\n", "true v_D",
               fmt::format("{:.4f}", 1e3 * v_D));
    fmt::print("  {:<22}{:>24}\n", "measured minus true",
               fmt::format("{} = {:+.2f} standard errors", report::speed_difference(r.v_D, v_D, 5),
                           (r.v_D.value - v_D) / r.v_D.sigma));
    fmt::print("  {:<22}{:>24} mm/s\n", "Coulomb on this base",
               fmt::format("{:.4f}", 1e3 * coulomb_drift(measured_base(r), r.frequency.value, scene)));
    const double ideal = coulomb_drift(harmonics(asked), asked.frequency, scene);
    fmt::print("  {:<22}{:>24} mm/s; measured minus this {}\n", "Coulomb at set-point",
               fmt::format("{:.4f}", 1e3 * ideal), report::speed_difference(r.v_D, ideal, 3));
    fmt::print(
        "duration: {:.2f} s of experiment in {:.2f} s, {:.1f} times real time; rendering of pictures took "
        "{:.2f} s ({:.0f} %)\n",
        speed.virtual_s, speed.wall_s, speed.virtual_s / speed.wall_s, speed.render_s,
        100 * speed.render_s / speed.wall_s);
}

void print_json(run::Runner& runner, const run::FinishedRun& ended) {
    const run::Results& results = ended.results;
    if (!results.reduction) {
        report::say(report::trips_json(results.trips, results.not_reduced) + "\n");
        return;
    }
    const calibration::ClockFit clock = ended.run.streams.timebase.dac();
    std::map<std::string, double> more{{"from_s", results.part.from_s},
                                       {"to_s", results.part.to_s},
                                       {"dac_ppm", clock.ppm},
                                       {"dac_ppm_se", clock.ppm_sigma}};
    const Drive& asked = runner.options().drive;
    if (const auto& world = runner.bench().world) {
        more["v_D_true_mps"] = drift_velocity(world->truth(0), results.part.from_s, results.part.to_s);
        more["v_D_asked_mps"] = coulomb_drift(harmonics(asked), asked.frequency, runner.bench().scene);
    }
    report::say(
        report::results_json(*results.reduction, more, device_reports(runner.bench().rig), results.trips) +
        "\n");
}

void print_text(run::Runner& runner, const run::FinishedRun& ended) {
    const run::Results& results = ended.results;
    report::say(ended.run.header.title + "\n");
    for (const recording::RecordedTrip& trip : results.trips)
        report::say(fmt::format("a limit stopped this run {}\n", text(trip)));
    if (!results.reduction) {
        report::say(fmt::format("no results: {}\n", results.not_reduced));
        return;
    }
    report::say(report::results_text(*results.reduction));
    if (const auto clamped = runner.collector().channels().lost.samples_clamped.load(); clamped > 0)
        fmt::print("{} samples of the drive were limited to {} V\n", clamped,
                   runner.bench().rig.dac->info().full_scale_V);
    if (const auto& world = runner.bench().world)
        print_truth(*results.reduction,
                    drift_velocity(world->truth(0), results.part.from_s, results.part.to_s),
                    runner.options().drive, runner.bench().scene,
                    {runner.wall_s(), runner.played_s(), world->render_seconds()});
    if (ended.whole && !ended.failure) report::say(fmt::format("recorded: {}\n", ended.file.string()));
}

std::string why_failed(const run::FinishedRun& ended) try {
    if (ended.failure) std::rethrow_exception(ended.failure);
    return {};
} catch (const std::exception& e) {
    return e.what();
}

// Reports the reason of the stop even when the file could not be written.
[[noreturn]] void throw_trip(const run::FinishedRun& ended) {
    const safety::Trip& trip = ended.run.stops.front().trip;
    if (const auto& why = ended.recorder_failure)
        throw DeviceError{
            fmt::format("{}; the drive was stopped softly ({}); \"shakerd recover {}\" completes the data "
                        "recorded until then",
                        *why, text(trip), ended.file.string() + ".part")};
    std::string file = "nothing could be recorded: " + why_failed(ended);
    if (!ended.failure)
        file = ended.whole ? "recorded: " + ended.file.string()
                           : fmt::format("last {} s recorded: {}", acquisition::tail_s, ended.file.string());
    throw TripError{text(trip) + "; " + file};
}

}  // namespace

void run(const run::RunOptions& options) {
    if (const auto folder = options.out.parent_path();
        !folder.empty() && !std::filesystem::is_directory(folder))
        throw InputError{fmt::format("--output {}: there is no folder {}; make it first (mkdir -p {})",
                                     options.out.string(), folder.string(), folder.string())};
    run::Runner runner{{.run = options, .recordings = options.trips}};
    for (const std::string& granted : runner.bench().granted) spdlog::info("{}", granted);
    const StopSignals signals{runner};
    const run::FinishedRun ended = runner.run();
    const bool stopped = !ended.run.stops.empty();
    if (ended.abandoned || (!stopped && ended.failure)) {
        if (ended.results.reduction) (options.json ? print_json : print_text)(runner, ended);
        std::rethrow_exception(ended.failure);
    }
    if (!stopped && !ended.results.reduction) {
        StopSignals::rethrow();
        throw InputError{ended.results.not_reduced +
                         (ended.whole ? "; recorded: " + ended.file.string() : "")};
    }
    (options.json ? print_json : print_text)(runner, ended);
    if (stopped) throw_trip(ended);
    if (ended.run.interrupted) StopSignals::rethrow();
}

}  // namespace shaker::commands

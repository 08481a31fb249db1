#include "daemon/commands/run.hpp"

#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>

#include <cmath>
#include <cstdio>
#include <exception>
#include <numbers>

#include "daemon/commands/table.hpp"
#include "daemon/report/printing.hpp"
#include "daemon/report/results.hpp"
#include "daemon/run/run_setup.hpp"
#include "daemon/run/runner.hpp"
#include "daemon/run/stop_signals.hpp"
#include "drivers/errors.hpp"
#include "drivers/walker/steady_state.hpp"

namespace shaker::commands {

namespace {

using manual::Argument;
using manual::Kind;

constexpr auto run_arguments = manual::joined(
    std::array{
        manual::rig_argument, manual::scene_argument,
        Argument{.name = "--settings",
                 .value = "FILE",
                 .help = "TOML file with a table [run]; options on the command line replace its values",
                 .kind = Kind::file}},
    manual::drive_arguments(true),
    std::array{
        manual::argument_of(point_field("periods"), true), manual::argument_of(point_field("settle"), true),
        manual::quantity_option(
            "--mu", "MU", Dimension::ratio, {0, 10},
            "Friction coefficient of walker and base: the run notes the predicted walk and the periods "
            "until the edge limit before it starts",
            {}, "the walk is not predicted"),
        Argument{.name = "--output",
                 .letter = 'o',
                 .value = "FILE",
                 .help = "Recording (HDF5)",
                 .kind = Kind::file,
                 .otherwise = "only trips are recorded"},
        Argument{
            .name = "--trips",
            .value = "FOLDER",
            .help = "Folder for trip-<UTC>.nxs, the last 2 s of a run without --output that a limit stopped",
            .kind = Kind::folder,
            .standard = ".",
            .must_exist = true},
        frames_argument,
        Argument{
            .name = "--no-identify",
            .help = "Use the response of the data sheet; do not identify the base's response before the run"},
        Argument{
            .name = "--uncommissioned",
            .help = "Drive a bench without a valid record of \"check --commission\", at half its limits"},
        Argument{.name = "--open-loop", .help = "Do not correct the drive by the measured motion"},
        Argument{.name = "--threads",
                 .help = "Run each loop in its own thread, as on hardware, instead of in lockstep"},
        Argument{.name = "--real-time", .help = "With --threads: run a simulated rig in real time"},
        manual::json_argument});

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

void print_run_json(run::Runner& runner, const run::FinishedRun& ended) {
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
        more["v_D_true_mps"] =
            drift_velocity(world->truth(0), results.part.from_s, results.part.to_s, asked.frequency);
        more["v_D_asked_mps"] = coulomb_drift(harmonics(asked), asked.frequency, runner.bench().scene);
    }
    report::say(
        report::results_json(*results.reduction, more, device_reports(runner.bench().rig), results.trips) +
        "\n");
}

void print_run_text(run::Runner& runner, const run::FinishedRun& ended) {
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
                    drift_velocity(world->truth(0), results.part.from_s, results.part.to_s,
                                   runner.options().drive.frequency),
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

run::RunOptions run_options(const manual::Values& values) {
    run::RunOptions options;
    if (values.has("--settings")) read_run_settings(values.text("--settings"), options);
    if (values.has("--rig")) options.rig = values.text("--rig");
    if (values.has("--scene")) options.scene = values.text("--scene");
    options.drive = changed_drive(values, options.drive);
    for (const MeasurementField& field : measurement_fields)
        if (field.lasts && values.has(field.option)) options.plan.*field.member = values.whole(field.option);
    if (values.has("--mu")) options.mu = {values.number("--mu"), 0};
    options.out = values.text("--output");
    options.trips = values.text("--trips");
    if (values.has("--frames"))
        options.pictures = recorded::kept_pictures_named(values.text("--frames")).value_or(options.pictures);
    if (values.has("--no-identify")) options.identify = false;
    if (values.has("--open-loop")) options.closed_loop = false;
    options.uncommissioned = values.has("--uncommissioned");
    options.threads = values.has("--threads");
    options.real_time = values.has("--real-time");
    options.json = values.has("--json");
    return options;
}

void run(const run::RunOptions& options) {
    if (const auto folder = options.out.parent_path();
        !folder.empty() && !std::filesystem::is_directory(folder))
        throw InputError{fmt::format("--output {}: there is no folder {}; make it first (mkdir -p {})",
                                     options.out.string(), folder.string(), folder.string())};
    run::Runner runner{{.run = options, .recordings = options.trips}};
    run::require_pictures(runner.bench().rig, options.drive.frequency);
    for (const std::string& granted : runner.bench().granted) spdlog::info("{}", granted);
    const run::StopSignals signals{runner};
    const run::FinishedRun ended = runner.run();
    const bool stopped = !ended.run.stops.empty();
    if (ended.abandoned || (!stopped && ended.failure)) {
        if (ended.results.reduction) (options.json ? print_run_json : print_run_text)(runner, ended);
        std::rethrow_exception(ended.failure);
    }
    if (!stopped && !ended.results.reduction) {
        run::StopSignals::rethrow();
        throw InputError{ended.results.not_reduced +
                         (ended.whole ? "; recorded: " + ended.file.string() : "")};
    }
    (options.json ? print_run_json : print_run_text)(runner, ended);
    if (stopped) throw_trip(ended);
    if (ended.run.interrupted) run::StopSignals::rethrow();
}

namespace {

int act_on_run(const manual::Values& values) {
    if (const std::string doubt = manual::doubtful_gamma(values); !doubt.empty()) spdlog::warn("{}", doubt);
    run(run_options(values));
    return manual::exit_ok;
}

}  // namespace

manual::Command run_row() {
    return {
        .name = "run",
        .summary = "Drive a rig, measure, track, reduce and record",
        .details =
            "The command identifies the response of the base, starts the drive softly, waits until base and "
            "walker have settled, measures, and prints the results.",
        .arguments = run_arguments,
        .example = "shakerd run --rig sim: --gamma 1.5g --phi 35deg --periods 40 -o run.nxs",
        .exit_statuses = {manual::exit_device, manual::exit_tripped, manual::exit_signal},
        .act = act_on_run};
}

}  // namespace shaker::commands

#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <numbers>

#include "daemon/commands.hpp"
#include "daemon/director.hpp"
#include "daemon/drive_rig.hpp"
#include "daemon/identification_record.hpp"
#include "daemon/paced_dac.hpp"
#include "daemon/recording_watch.hpp"
#include "daemon/results.hpp"
#include "daemon/rigs.hpp"
#include "daemon/run_setup.hpp"
#include "daemon/stopped_run.hpp"
#include "drivers/errors.hpp"
#include "drivers/region_camera.hpp"
#include "drivers/simulated/steady_state.hpp"

namespace shaker {

namespace {

Harmonics<Acceleration> measured_base(const Reduction& r) {
    Harmonics<Acceleration> base;
    for (const MeasuredHarmonic& h : r.harmonics)
        if (h.q <= max_harmonics) base.at(h.q) = std::polar(h.amplitude.value, h.phase.value);
    return base;
}

// What exact Coulomb friction with the scene's coefficients makes of a motion of the base.
double coulomb_drift(const Harmonics<Acceleration>& base, double frequency, const Scene& scene) {
    WalkerSetting setting;
    setting.frequency = frequency;
    setting.base = base;
    setting.tilt = scene.tilt_deg * std::numbers::pi / 180;
    setting.g = scene.gravity;
    setting.friction = {scene.walker.mu_k, scene.walker.mu_s, 0};
    return settle(WalkerLaw{setting}).v_D;
}

using Recorder = std::function<bool()>;

struct Speed {
    double wall_s, virtual_s, render_s;
};

// Before anything moves: what is asked for must be within the limits. The DAC may run empty: a run comes up
// softly again by itself, some times.
Limits limits_of_run(const OpenRig& bench, const Drive& drive) {
    require_within(run_demands(bench, drive, bench.limits));
    Limits limits = bench.limits;
    limits.detectors.reset(static_cast<std::size_t>(Cause::underrun));
    return limits;
}

// What a stopped run leaves behind; says where. Trouble with the file does not hide why it was stopped.
std::string record_stop(const RunOptions& options, Recording& recording, const SessionHeader& header,
                        const Director& director, Acquisition& acquisition) try {
    const bool measuring = director.stops().at(director.cause()).measuring;
    const DriveKeeper& keeper = director.keeper();
    const StoppedRun run{
        .header = header,
        .take = acquisition.take(),
        .tails = acquisition.tails(),
        .trips = recorded_trips(acquisition.take(), director),
        .planned = measuring ? MeasuredPart{director.from_s(), director.to_s()} : MeasuredPart{},
        .identified = keeper.identified() ? &*keeper.identified() : keeper.found()};
    if (recording.on()) {
        finish(recording, run);
        return "recorded: " + options.out.string();
    }
    const std::filesystem::path file = trip_file(options.trips, std::chrono::system_clock::now());
    record_tail(run, file);
    return fmt::format("its last {} s: {}", tail_s, file.string());
} catch (const std::exception& e) {
    return fmt::format("nothing could be recorded: {}", e.what());
}

void print_truth(const Reduction& r, double v_D, const Drive& asked, const Scene& scene, const Speed& speed) {
    const double off = r.v_D.value - v_D;
    fmt::print("the simulated truth beside it:\n  {:<22}{:>24} mm/s\n", "v_D of the scene",
               fmt::format("{:.4f}", 1e3 * v_D));
    fmt::print("  {:<22}{:>24}\n", "measured minus true",
               fmt::format("{:+.3f} um/s = {:+.5f} % = {:+.2f} standard errors", 1e6 * off, 100 * off / v_D,
                           off / r.v_D.sigma));
    fmt::print("  {:<22}{:>24} mm/s\n", "Coulomb on this base",
               fmt::format("{:.4f}", 1e3 * coulomb_drift(measured_base(r), r.frequency.value, scene)));
    const double ideal = coulomb_drift(harmonics(asked), asked.frequency, scene);
    fmt::print("  {:<22}{:>24} mm/s; measured minus this {:+.3f} %\n", "on the asked drive",
               fmt::format("{:.4f}", 1e3 * ideal), 100 * (r.v_D.value - ideal) / std::abs(ideal));
    fmt::print(
        "cost: {:.2f} s of experiment in {:.2f} s, {:.1f} times real time; rendering the pictures took "
        "{:.2f} s "
        "({:.0f} %) of it\n",
        speed.virtual_s, speed.wall_s, speed.virtual_s / speed.wall_s, speed.render_s,
        100 * speed.render_s / speed.wall_s);
}

}  // namespace

void run(const RunOptions& options) {
    OpenRig bench =
        open_rig(options.rig, options.scene, options.threads ? World::Pace::paced : World::Pace::lockstep);
    for (const std::string& granted : bench.granted) spdlog::info("{}", granted);
    Rig& rig = bench.rig;
    if (options.threads && options.real_time && bench.world)
        rig.dac = std::make_unique<PacedDac>(std::move(rig.dac));
    const DacInfo dac = rig.dac->info();
    const bool live = runs_threaded(bench, options.threads);
    if (options.pictures == KeptPictures::region && !options.out.empty()) take_regions(rig);
    const SessionHeader header = run_header(bench, options, live, bench.world != nullptr);

    Recording recording{options.out, header, {.live = live}};
    const Limits limits = limits_of_run(bench, options.drive);
    Acquisition acquisition{rig, &recording, limits, options.drive.frequency};
    if (options.out.empty() || options.pictures == KeptPictures::off) acquisition.keep_tails();
    Output output{dac,    options.drive.frequency,          trigger_rate(rig), dac.block_frames,
                  limits, rig.accelerometer->info().rate_hz};
    Director director{run_plan(bench, options, limits), dac.rate_hz, rig.accelerometer->info(),
                      [](const std::string& what) { spdlog::info("{}", what); }};

    RecordingWatch watch{recording};
    const Execution execution = drive_rig(
        bench, acquisition, output, options.threads,
        [&](const Take& take, Lanes& lanes) {
            const bool any = director.step(take, lanes);
            watch.look(director, take, lanes);
            return any;
        },
        [&] { return director.done(); },
        live && recording.on() ? Recorder{[&] { return recording.step(); }} : Recorder{});
    for (const std::string& refused : execution.refused) spdlog::warn("{}", refused);

    Take& take = acquisition.take();
    std::vector<std::string> notes;
    settle_times(take, notes);
    if (director.trip()) {
        const std::string file = record_stop(options, recording, header, director, acquisition);
        if (const auto why = recording.failure())
            throw DeviceError{
                fmt::format("{}; the drive came down softly ({}); \"shakerd recover {}\" finishes what was "
                            "recorded before",
                            *why, text(*director.trip()), options.out.string() + ".part")};
        throw TripError{text(*director.trip()) + "; " + file};
    }
    Reduction r = reduce(measurement_of(take, header.frequency_hz, director.from_s(), director.to_s()));
    std::ranges::move(notes, std::back_inserter(r.notes));
    for (std::string& note : notes_on(take)) r.notes.push_back(std::move(note));
    const std::vector<DeviceReport> devices = device_reports(rig);
    std::ranges::move(notes_on(devices), std::back_inserter(r.notes));
    std::ranges::copy(director.notes(), std::back_inserter(r.notes));
    std::ranges::move(notes_on(acquisition.lanes().warnings), std::back_inserter(r.notes));
    double v_D = NAN;
    if (bench.world) {
        v_D = drift_velocity(bench.world->truth(0), director.from_s(), director.to_s());
        if (recording.on()) recording.writer().scalar("truth/v_D", v_D);
        for (std::size_t i = 0; recording.on() && i < header.views.size(); ++i)
            write(recording.writer(), {truth_table(header.views[i].camera, bench.world->truth(i))});
    }
    if (const auto& found = director.keeper().identified(); found && recording.on())
        write_identification(recording.writer(), *found);
    recording.finish(take, r, director.from_s(), director.to_s());

    if (options.json) {
        ClockTracker<DacClock> clock{dac.rate_hz};
        for (const PlayTime& played : take.played) follow(clock, played);
        std::map<std::string, double> more{{"from_s", director.from_s()},
                                           {"to_s", director.to_s()},
                                           {"dac_ppm", clock.ppm()},
                                           {"dac_ppm_se", clock.ppm_sigma()}};
        if (bench.world) {
            more["v_D_true_mps"] = v_D;
            more["v_D_asked_mps"] =
                coulomb_drift(harmonics(options.drive), options.drive.frequency, bench.scene);
        }
        std::fputs((results_json(r, more, devices) + "\n").c_str(), stdout);
        return;
    }
    fmt::print("{}\n", header.title);
    std::fputs(results_text(r).c_str(), stdout);
    if (const auto clamped = acquisition.lanes().lost.samples_clamped.load(); clamped > 0)
        fmt::print("{} samples of the drive were cut at {} V\n", clamped, dac.full_scale_V);
    if (bench.world)
        print_truth(r, v_D, options.drive, bench.scene,
                    {execution.wall_s, static_cast<double>(output.synthesiser.tick().n) / dac.rate_hz,
                     bench.world->render_seconds()});
    if (!options.out.empty()) fmt::print("recorded: {}\n", options.out.string());
}

}  // namespace shaker

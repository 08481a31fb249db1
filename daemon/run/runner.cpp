#include "daemon/run/runner.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <exception>
#include <iterator>
#include <utility>

#include "daemon/acquisition/executors.hpp"
#include "daemon/acquisition/streams.hpp"
#include "daemon/bench/region_camera.hpp"
#include "daemon/run/run_setup.hpp"
#include "daemon/safety/preflight.hpp"
#include "drivers/errors.hpp"
#include "drivers/time.hpp"

namespace shaker::run {

namespace {

// Why the run has half the limits of its bench; empty: it has the full ones.
std::string half_limits(const bench::Bench& bench, const RunOptions& run) {
    std::string why;
    if (run.uncommissioned) why = bench.not_commissioned;
    if (!gain_shown(bench.rig))
        why.append(why.empty() ? "" : "; ")
            .append("neither gravity nor a camera that sees the base shows the accelerometer's gain");
    return why.empty() ? why : "all limits are halved: " + why;
}

bench::Bench open(const RunnerSettings& settings) {
    const RunOptions& run = settings.run;
    bench::Bench bench = bench::open_bench(
        run.rig, run.scene, run.threads ? simulated::World::Pace::paced : simulated::World::Pace::lockstep,
        run.standard);
    require_seen(bench, run.drive);
    if (run.threads && run.real_time && bench.world)
        bench.rig.dac = std::make_unique<acquisition::PacedDac>(std::move(bench.rig.dac));
    if ((run.pictures == recorded::KeptPictures::region ||
         run.pictures == recorded::KeptPictures::first_second) &&
        (settings.on_call || !run.out.empty()))
        bench::take_regions(bench.rig);
    if (const std::string why = half_limits(bench, run); !why.empty()) {
        spdlog::warn("{}", why);
        bench.limits = safety::halved(bench.limits);
        bench.halved = true;
    }
    return bench;
}

acquisition::DriveOutput output_for(const bench::Bench& bench, double frequency,
                                    const safety::Limits& limits) {
    const DacInfo dac = bench.rig.dac->info();
    return {dac,
            frequency,
            acquisition::trigger_rate(bench.rig),
            dac.block_frames,
            limits,
            bench.rig.accelerometer->info().rate_hz};
}

RunPlan plan_for(const bench::Bench& bench, const RunnerSettings& settings, const safety::Limits& limits) {
    RunPlan plan = run_plan(bench, settings.run, limits);
    plan.on_call = settings.on_call;
    if (const std::string why = half_limits(bench, settings.run); !why.empty()) plan.notes.push_back(why);
    return plan;
}

}  // namespace

Runner::Runner(const RunnerSettings& settings)
    : settings_{settings},
      bench_{open(settings)},
      live_{acquisition::runs_threaded(bench_, settings.run.threads)},
      limits_{limits_of_run(bench_.limits)},
      collector_{bench_.rig, nullptr, limits_, settings.run.drive.frequency},
      output_{output_for(bench_, settings.run.drive.frequency, limits_)},
      sequence_{plan_for(bench_, settings, limits_), bench_.rig.dac->info().rate_hz,
                bench_.rig.accelerometer->info(),
                [level = settings.on_call ? spdlog::level::debug : spdlog::level::info](
                    const std::string& what) { spdlog::log(level, "{}", what); }},
      recordings_{bench_,
                  collector_,
                  {.folder = settings.recordings,
                   .most_s = settings.on_call ? settings.longest_recording_s : INFINITY,
                   .live = live_,
                   .on_call = settings.on_call}} {
    if (!settings.on_call) return;
    collector_.settle_live();
    collector_.keep_tails();
}

double Runner::played_s() const noexcept {
    return counted_s(output_.synthesiser.tick(), bench_.rig.dac->info().rate_hz);
}

void Runner::lead(const acquisition::Lead& step, const std::function<bool()>& done) {
    const bool records = live_ && (settings_.on_call || recordings_.on());
    wall_s_ = run_loops(bench_, collector_, output_, settings_.run.threads,
                        {.lead =
                             [&](const acquisition::Streams& streams, acquisition::Channels& channels) {
                                 watch_mixers(channels);
                                 return step(streams, channels);
                             },
                         .done = done,
                         .recorder = records ? std::function<bool()>{[this] { return recordings_.step(); }}
                                             : std::function<bool()>{},
                         .begun =
                             [this](const std::vector<acquisition::RealTimeGrant>& grants) {
                                 real_time_ = grants;
                                 for (const acquisition::RealTimeGrant& g : grants)
                                     if (!g.refused.empty()) spdlog::warn("{}", g.refused);
                             }});
}

void Runner::require_real_time() const {
    const auto refused = std::ranges::find_if(
        real_time_, [](const acquisition::RealTimeGrant& g) { return !g.refused.empty(); });
    if (refused == real_time_.end() || !bench_.real_time_required) return;
    throw DeviceError{
        fmt::format("{}; a drive without it may stop by itself at any time. Allow it, or set real_time = "
                    "\"wanted\" in {}",
                    refused->refused, bench_.rig.name)};
}

void Runner::require_commissioned() const {
    if (const auto [why, changed] = bench::mixers_changed(bench_); changed > 0) throw InputError{why};
    if (settings_.commissioning || settings_.run.uncommissioned || bench_.not_commissioned.empty()) return;
    throw InputError{bench_.not_commissioned +
                     (settings_.on_call ? "" : "; or add --uncommissioned, which halves all limits")};
}

// Once a second while something is driven: a changed volume is a changed gain.
commissioned::MixerChange Runner::changed_mixers(double now_s) {
    constexpr double every_s = 1;
    if (bench_.rig.mixers.empty() || now_s < mixers_read_s_ + every_s) return {};
    mixers_read_s_ = now_s;
    commissioned::MixerChange change = bench::mixers_changed(bench_);
    if (change.controls > 0) spdlog::error("{}", change.why);
    return change;
}

void Runner::watch_mixers(acquisition::Channels& channels) {
    if (!driving(sequence_.state())) return;
    if (const int changed = changed_mixers(sequence_.now_s()).controls; changed > 0)
        sequence_.stop(channels, {.cause = safety::Cause::mixer, .value = static_cast<double>(changed)});
}

void Runner::obey_stop_requests(acquisition::Channels& channels) {
    const int requests = stop_requests_;
    if (requests == obeyed_) return;
    if (requests > 1) ++channels.aborts;
    if (obeyed_ == 0) sequence_.leave(channels);
    obeyed_ = requests;
}

// The reduction needs the measurement with a margin, a stop the last seconds. A recording needs the stamps of
// all frames and, of a simulated walker, its whole way.
void Runner::tidy() {
    const bool measuring = sequence_.to_s() > sequence_.from_s();
    if (bench_.world && !recordings_.on())
        bench_.world->keep_truth_for(measuring ? INFINITY : kept_streams_s);
    if (measuring) return;
    acquisition::Streams& streams = collector_.streams();
    const double f = settings_.run.drive.frequency, now_s = sequence_.now_s();
    const auto read = acquisition::part_read(streams, f, now_s, now_s + settings_.run.plan.periods / f);
    acquisition::drop_before(streams, std::min(now_s - kept_streams_s, read.from_s));
    if (!recordings_.on()) acquisition::drop_stamps(streams);
}

FinishedRun Runner::run() {
    require_commissioned();
    safety::require_within(run_demands(bench_, settings_.run.drive, bench_.limits),
                           settings_.run.drive.gamma);
    acquisition::require_memory(bench_.rig, settings_.run.plan.periods / settings_.run.drive.frequency);
    recordings_.begin(settings_.run, settings_.run.out, 0);
    if (settings_.run.out.empty() || !recorded::keeps_all(settings_.run.pictures)) collector_.keep_tails();
    try {
        lead(
            [this](const acquisition::Streams& streams, acquisition::Channels& channels) {
                require_real_time();
                const bool any = sequence_.step(streams, channels);
                obey_stop_requests(channels);
                recordings_.update(sequence_, channels);
                tidy();
                return any;
            },
            [this] { return sequence_.done(); });
    } catch (const DeviceError&) {
        return recordings_.abandon(sequence_, std::current_exception());
    }
    recordings_.finish(sequence_);
    while (recordings_.finishing()) recordings_.step();
    return std::move(*recordings_.finished());
}

std::vector<Finding> Runner::check(SelfTestPlan plan) {
    std::vector<Finding> findings;
    plan.gravity = bench_.gravity;
    for (std::size_t q = 0; q < max_harmonics; ++q)
        plan.response[q] = bench_.response(static_cast<double>(q + 1) * plan.frequency);
    const double rate_hz = bench_.rig.dac->info().rate_hz;
    SelfTest test{plan, rate_hz};
    std::string mixers;  // what has changed
    spdlog::info("self-test: {:.3g} s of silence, then {} periods of {:.3g} V at {:.4g} and {:.4g} Hz",
                 plan.quiet_s, plan.hold, plan.volts, plan.frequency, 2 * plan.frequency);
    try {
        lead(
            [&](const acquisition::Streams& streams, acquisition::Channels& channels) {
                require_real_time();
                if (const int requests = stop_requests_; requests != obeyed_) {
                    if (requests > 1) ++channels.aborts;
                    test.leave(channels.drive);
                    obeyed_ = requests;
                }
                const double now_s =
                    streams.played.empty() ? 0 : counted_s(streams.played.back().tick, rate_hz);
                if (mixers.empty() && !(mixers = changed_mixers(now_s).why).empty())
                    test.leave(channels.drive);
                return test.step(streams, channels.drive);
            },
            [&] { return test.done(); });
    } catch (const DeviceError& e) {
        return {{Verdict::bad, "self-test", e.what()}};
    }
    for (const acquisition::RealTimeGrant& g : real_time_)
        if (!g.refused.empty()) findings.push_back({Verdict::warning, "real time", g.refused});
    const char* const drive = test.drove() ? "; the drive was stopped softly" : "; nothing was driven";
    if (stop_requests_ > 0 || !mixers.empty()) {
        findings.push_back(stop_requests_ > 0
                               ? Finding{Verdict::bad, "self-test", fmt::format("interrupted{}", drive)}
                               : Finding{Verdict::bad, "mixer", mixers + drive});
        return findings;
    }
    for (const std::string& what : notes_on(collector_.channels().warnings))
        findings.push_back({Verdict::warning, "limits", what});
    if (test.trip()) {
        findings.push_back({Verdict::bad, "self-test", "the drive was stopped: " + text(*test.trip())});
        return findings;
    }
    std::ranges::move(judge(test, bench_.rig, collector_), std::back_inserter(findings));
    return findings;
}

}  // namespace shaker::run

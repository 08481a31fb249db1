#include "daemon/campaign/lead/campaign.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <numbers>
#include <utility>

#include "drivers/errors.hpp"

namespace shaker::campaign {

namespace {

constexpr double track_bytes_per_s = 0.5e6;  // of a recording without pictures

std::string why_of(const std::exception_ptr& failure) try {
    std::rethrow_exception(failure);
} catch (const std::exception& e) {
    return e.what();
}

}  // namespace

Campaign::Campaign(run::Runner& runner, on_call::OnCall& on_call, Engine& engine,
                   const CampaignSettings& settings, Listener listener)
    : runner_{runner},
      engine_{engine},
      settings_{settings},
      listener_{std::move(listener)},
      on_call_{on_call},
      drive_{settings.run.drive},
      timed_to_s_{runner.sequence().now_s()} {}

void Campaign::order(acquisition::Channels& channels) {
    try {
        finish_start();
        carry_out(engine_.next(seen(channels)), channels);
    } catch (const std::exception& e) {
        starts_ = false;
        if (!engine_.paused()) engine_.refused(e.what());
    }
}

void Campaign::finish_start() {
    if (!starts_ || !on_call_.begun()) return;
    starts_ = false;
    recording_from_s_ = runner_.sequence().now_s();
}

void Campaign::take(const run::FinishedRun& run) {
    if (run.failure) engine_.failed("a recording could not be completed: " + why_of(run.failure));
}

void Campaign::follow() {
    count_time();
    for (const Event& event : engine_.events()) listener_(event, runner_.sequence().now_s());
}

void Campaign::count_time() {
    const run::Sequence& sequence = runner_.sequence();
    const double passed_s = sequence.now_s() - std::exchange(timed_to_s_, sequence.now_s());
    const bool drives = run::driving(sequence.state());
    if (engine_.paused() && !drives) return;
    const bool steady = sequence.state() == run::RunState::run;
    double& use = !steady                ? time_.checking
                  : engine_.returning()  ? time_.returning
                  : sequence.measuring() ? time_.measuring
                                         : time_.settling;
    use += passed_s;
}

Seen Campaign::seen(const acquisition::Channels& channels) const {
    const run::Sequence& sequence = runner_.sequence();
    run::RunState state = on_call_.state();
    if (state == run::RunState::run && !sequence.may_set()) state = run::RunState::ramp;
    Seen s{.now_s = sequence.now_s(),
           .state = state,
           .trip = sequence.trip() ? text(*sequence.trip()) : std::string{},
           .may_start = state == run::RunState::idle && !channels.stopped,
           .identified = !settings_.run.identify || sequence.controller().identified().has_value(),
           .holding = sequence.holding(),
           .pending = on_call_.pending(),
           .recorded_s = sequence.now_s() - recording_from_s_,
           .free_bytes = runner_.recordings().free_bytes(),
           .bytes_per_s = track_bytes_per_s + pictures_per_s(),
           .x_m = sequence.walker().x_m().value_or(unknown)};
    const Point* point = engine_.point();
    if (!sequence.walker().watches() || point == nullptr) return s;
    const double inside_mm =
        on_call_.limits().edge_mm + settings_.edge_margin_mm + on_call_.oscillation_mm(point->asked.drive);
    if (const auto ways_m = sequence.walker().ways_m(inside_mm); std::isfinite(ways_m[0])) s.way = ways_m;
    return s;
}

double Campaign::pictures_per_s() const {
    if (!recorded::keeps_all(settings_.run.pictures)) return 0;
    const auto& cameras = runner_.bench().rig.cameras;
    double bytes = 0;
    for (std::size_t i = 0; i < cameras.size(); ++i)
        if (const FramePtr& frame = runner_.collector().newest(i).frame)
            bytes += cameras[i]->view().frame_rate_hz * static_cast<double>(frame->pixels.size());
    return bytes;
}

void Campaign::carry_out(const Action& action, acquisition::Channels& channels) {
    if (const auto* start = std::get_if<Start>(&action)) {
        run::RunOptions run = settings_.run;
        run.drive = drive_ = start->drive;
        run.plan.periods = std::max(start->task.plan.periods, 2);
        const auto file = settings_.folder / fmt::format("r{:03}.nxs", ++settings_.recordings);
        on_call_.begin(run, start->task, file, engine_.walk(start->drive), channels);
        starts_ = true;
        finish_start();
    } else if (const auto* change = std::get_if<Change>(&action)) {
        on_call_.set(change->drive, change->task, channels);
        drive_ = change->drive;
    } else if (std::holds_alternative<Stop>(action)) {
        on_call_.end(channels);
    }
}

std::string place(const Point& p) {
    return fmt::format("{} {:.4g} Hz gamma {:.4g} m/s^2 rho {:.3g} phi {:.1f} deg", p.series,
                       p.asked.drive.frequency, p.asked.drive.gamma, p.asked.drive.rho,
                       p.asked.drive.phi * 180 / std::numbers::pi);
}

std::string text(const Event& event, const Engine& engine, const std::vector<Point>& points) {
    if (const auto* ended = std::get_if<PointEnded>(&event)) {
        const calibration::Estimate v_D = engine.result(ended->point);
        const std::string result =
            ended->outcome == Outcome::measured
                ? fmt::format("v_D {:+.4f} +- {:.4f} mm/s", 1e3 * v_D.value, 1e3 * v_D.sigma)
                : fmt::format("{}: {}", outcome_words[static_cast<std::size_t>(ended->outcome)],
                              ended->reason);
        return fmt::format("point {} of {}  {}  {}", ended->point, points.size(),
                           place(points.at(static_cast<std::size_t>(ended->point - 1))), result);
    }
    if (const auto* change = std::get_if<CampaignChange>(&event))
        return fmt::format("{}: {}", CampaignChange::words[static_cast<std::size_t>(change->what)],
                           change->reason);
    if (const auto* lost = std::get_if<PassLost>(&event))
        return fmt::format("point {}, pass {} does not count: {}", lost->point, lost->pass, lost->reason);
    return {};
}

}  // namespace shaker::campaign

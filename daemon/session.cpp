#include "daemon/session.hpp"

#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "daemon/reduction/no_stick.hpp"
#include "daemon/run_settings.hpp"
#include "daemon/run_setup.hpp"
#include "daemon/state_report.hpp"
#include "drivers/errors.hpp"

namespace shaker {

namespace {

constexpr double publish_s = 0.1;         // of master time
constexpr double kept_s = 12;             // of what was measured, when nothing needs more
constexpr std::size_t most_points = 500;  // measurements that are shown
constexpr int longest_measurement_s = 100;

RunPlan plan_of(const OpenRig& bench, const RunOptions& run) {
    RunPlan plan = run_plan(bench, run, limits_on_call(bench.limits));
    plan.on_call = true;
    return plan;
}

void require(const char* what, double value, Range range, const std::string& unit) {
    if (value >= range.min && value <= range.max) return;
    throw InputError{
        fmt::format("{} {}{}: {}{} is allowed", what, to_text(value), unit, to_text(range), unit)};
}

void require_lower(const char* what, double now, double wanted) {
    if (wanted <= now) return;
    throw InputError{
        fmt::format("limit {} {}: at most the present {} is allowed; limits are raised in the settings file "
                    "only",
                    what, to_text(wanted), to_text(now))};
}

}  // namespace

Limits limits_on_call(Limits limits) {
    limits.detectors.reset(static_cast<std::size_t>(Cause::underrun));
    return limits;
}

Session::Session(OpenRig& bench, Acquisition& acquisition, const SessionSettings& settings, Desk& desk)
    : bench_{bench},
      acquisition_{acquisition},
      run_{settings.run},
      opened_{settings.run.pictures},
      beside_{settings.beside},
      desk_{desk},
      limits_{limits_on_call(bench.limits)},
      director_{plan_of(bench, settings.run), bench.rig.dac->info().rate_hz, bench.rig.accelerometer->info(),
                [](const std::string& what) { spdlog::debug("{}", what); }},
      record_{bench, acquisition, settings.record},
      report_{std::make_unique<StateReport>(bench, acquisition, director_, desk.feed())} {
    BenchFacts facts{.rig = bench.rig.name,
                     .dac = bench.rig.dac->info(),
                     .accelerometer = bench.rig.accelerometer->info(),
                     .views = {},
                     .soft_start_periods = plan_of(bench, settings.run).soft_start,
                     .recordings = settings.record.folder,
                     .mu = settings.mu};
    for (const auto& camera : bench.rig.cameras) facts.views.push_back(camera->view());
    mu_ = facts.mu;
    facts_ = std::make_shared<const BenchFacts>(std::move(facts));
    predicted_ = run_demands(bench_, run_.drive, limits_);
    acquisition.settle_live();
    if (bench.world) bench.world->keep_truth_for(kept_s);
    acquisition.keep_tails();
    desk.stop_by([&aborts = acquisition.lanes().aborts] { ++aborts; });
}

Session::~Session() = default;

bool Session::step(const Take& take, Lanes& lanes) {
    bool any = director_.step(take, lanes);
    report_->feed(take);
    measure(take);  // before an order changes what was asked for
    any = answer(lanes) || any;
    take_outcome();
    if (const std::uint64_t vain = lanes.lost.not_learned; std::exchange(not_learned_, vain) != vain)
        tell("note",
             "a camera's targets were not where they had been seen: tracked again from its pictures, "
             "what is recorded begins at other positions");
    record_.look(director_, lanes);
    follow_states();
    if (leaving_) go_away(lanes);
    const double now_s = director_.now_s();
    if (changed_ || now_s >= published_s_ + publish_s) publish();
    tidy(acquisition_.take());
    return any;
}

bool Session::answer(Lanes& lanes) {
    bool any = false;
    while (const auto order = desk_.next()) {
        any = true;
        std::string refused;
        try {
            std::visit([&](const auto& what) { obey(what, lanes); }, order->what);
        } catch (const std::exception& e) {
            refused = e.what();
        }
        ++answered_;
        publish();
        if (order->answer) order->answer(refused);
    }
    return any;
}

void Session::require_possible(const Drive& drive, const Limits& limits) const {
    require("frequency", drive.frequency, drive_limits.frequency, " Hz");
    require("gamma", drive.gamma, drive_limits.gamma, " m/s^2");
    require("rho", drive.rho, drive_limits.rho, "");
    require("phi", drive.phi, drive_limits.phi, " rad");
    for (const std::complex<double>& share : drive.overtones)
        require("share of an overtone", std::abs(share), drive_limits.share, " of gamma");
    require_within(run_demands(bench_, drive, limits));
}

void Session::obey(const SetDrive& order, Lanes& lanes) {
    require_possible(order.drive, limits_);
    const RunState state = director_.state();
    if (state == RunState::run) {
        if (record_.on() && order.drive.frequency != run_.drive.frequency)
            throw InputError{"the frequency of a run that is being recorded stays; stop it first"};
        director_.set(order.drive, lanes);
    } else if (driving(state)) {
        throw InputError{fmt::format(
            "the drive cannot be changed in state {}; wait until it runs, or stop it", name(state))};
    }
    run_.drive = order.drive;
    predicted_ = run_demands(bench_, run_.drive, limits_);
    armed_ = !driving(state);
}

void Session::obey(const Begin& order, Lanes& lanes) {
    const int most = static_cast<int>(longest_measurement_s * run_.drive.frequency);
    require("periods", order.periods, {2, static_cast<double>(most)}, "");
    require("settle_periods", order.settle, {0, most_settle_periods}, "");
    require_possible(run_.drive, limits_);
    if (director_.state() != RunState::idle || lanes.stopped)
        throw InputError{fmt::format("a run was asked for in state {}; it can be in state idle only",
                                     name(director_.state()))};
    run_.periods = order.periods;
    run_.settle = order.settle;
    record_.begin(run_, recorded_, name_);
    name_.clear();
    active_ = true;
    stop_told_ = false;
    measured_ = told_notes_ = 0;
    result_.reset();
    not_reduced_.clear();
    // Refused when an abort came just now: its trip ends the file.
    director_.begin(run_.drive, order.periods, order.settle, lanes);
}

void Session::obey(const Identify& /*order*/, Lanes& lanes) {
    require_possible(run_.drive, limits_);
    record_.begin(run_, false, {});
    director_.identify(run_.drive, lanes);
    told_notes_ = 0;
    active_ = true;
    stop_told_ = false;
}

void Session::obey(const End& /*order*/, Lanes& lanes) { director_.end(lanes); }

void Session::obey(const ClearTrip& /*order*/, Lanes& lanes) { director_.clear(lanes); }

void Session::obey(const Record& order, Lanes& /*lanes*/) {
    if (driving(director_.state()))
        throw InputError{fmt::format("recording was switched in state {}; it can be while nothing is driven",
                                     name(director_.state()))};
    if (!order.name.empty()) require_name(order.name);
    if (order.pictures != KeptPictures::off && order.pictures != opened_)
        throw InputError{
            fmt::format("pictures \"{}\": the cameras were opened for \"{}\"; that or \"off\" is allowed",
                        name(order.pictures), name(opened_))};
    recorded_ = order.on;
    name_ = order.name;
    run_.pictures = order.pictures;
}

void Session::obey(const Remark& order, Lanes& /*lanes*/) {
    require_remark(order.text);
    record_.remark(order.text, director_);
    tell("remark", order.text);
}

void Session::obey(const CloseLoop& order, Lanes& /*lanes*/) {
    director_.close_loop(order.on);
    run_.closed_loop = order.on;
}

void Session::obey(const LowerLimits& order, Lanes& lanes) {
    const Limits &now = limits_, &wanted = order.limits;
    const auto level = [](const char* what, const Level& a, const Level& b) {
        require_lower(what, a.warn, b.warn);
        require_lower(what, a.abort, b.abort);
    };
    level("acceleration", now.acceleration, wanted.acceleration);
    level("velocity", now.velocity, wanted.velocity);
    level("displacement", now.displacement, wanted.displacement);
    level("drive", now.drive, wanted.drive);
    level("transverse", now.transverse, wanted.transverse);
    require_lower("edge", -now.edge_mm, -wanted.edge_mm);
    take_limits(wanted, lanes);
}

void Session::obey(const Adopt& order, Lanes& lanes) {
    const RunState state = director_.state();
    if (driving(state))
        throw InputError{
            fmt::format("the settings cannot change in state {}; stop the drive first", name(state))};
    require_possible(order.drive, order.limits);
    run_.drive = order.drive;
    run_.periods = order.periods;
    run_.settle = order.settle;
    armed_ = false;
    take_limits(order.limits, lanes);
}

void Session::take_limits(const Limits& limits, Lanes& lanes) {
    const auto detectors = limits_.detectors;
    limits_ = limits;
    limits_.detectors = detectors;
    predicted_ = run_demands(bench_, run_.drive, limits_);
    director_.hold_to(limits_, lanes);
}

void Session::measure(const Take& take) {
    const std::vector<MeasuredPart>& parts = director_.measured();
    for (; measured_ < parts.size(); ++measured_) {
        const MeasuredPart part = parts[measured_];
        const double f = Synthesiser::realised(run_.drive.frequency, take.dac_rate_hz);
        auto work = [m = measurement_of(take, f, part.from_s, part.to_s)]() mutable -> Outcome {
            try {
                return std::make_shared<const Reduction>(reduce(std::move(m)));
            } catch (const InputError& e) {
                return std::string{e.what()};
            }
        };
        pending_.push_back(
            {run_.drive, part,
             std::async(beside_ ? std::launch::async : std::launch::deferred, std::move(work))});
    }
}

void Session::take_outcome() {
    while (!pending_.empty()) {
        Pending& p = pending_.front();
        if (p.outcome.wait_for(std::chrono::seconds{0}) == std::future_status::timeout) return;
        const Outcome outcome = p.outcome.get();
        changed_ = true;
        measured_from_s_ = p.part.from_s;
        if (const auto* why = std::get_if<std::string>(&outcome)) {
            not_reduced_ = *why;
            tell("note", "a measurement could not be reduced: " + *why);
        } else {
            result_ = std::get<std::shared_ptr<const Reduction>>(outcome);
            not_reduced_.clear();
            if (points_.size() == most_points) {
                points_.erase(points_.begin());
                parts_.erase(parts_.begin());
            }
            points_.push_back({p.asked, result_->gamma, result_->phi, result_->v_D});
            parts_.push_back(p.part);
            compare_points();
        }
        pending_.pop_front();
    }
}

// What the newest point says beside the others, and all beside the closed form.
void Session::compare_points() {
    mirror_ = mirror_pair(points_);
    if (const auto null = null_phase(points_)) null_ = null;
    if (null_ && std::isfinite(null_->mu.value)) mu_ = null_->mu;
    closed_form_.clear();
    for (const DrivenPoint& p : points_) {
        Drive measured = p.asked;
        measured.gamma = p.gamma.value;
        measured.phi = p.phi.value;
        closed_form_.push_back(std::isfinite(mu_.value)
                                   ? no_stick(harmonics(measured), measured.frequency, mu_.value).v_D
                                   : NAN);
    }
}

void Session::follow_states() {
    const RunState state = director_.state();
    for (; told_notes_ < director_.notes().size(); ++told_notes_)
        tell("note", director_.notes()[told_notes_]);
    if (state != state_) {
        state_ = state;
        if (driving(state) || state == RunState::tripped) armed_ = false;
        tell("state", name(state));
        response_ = director_.keeper().identified()
                        ? std::make_shared<const IdentifiedResponse>(*director_.keeper().identified())
                        : nullptr;
        if (state == RunState::tripped) {
            trip_s_ = director_.now_s();
            tell("trip", text(*director_.trip()));
        }
        if (state == RunState::idle && active_) {
            active_ = false;
            if (const std::string what = record_.finish(director_); !what.empty()) tell("note", what);
        }
    }
    if (director_.may_clear() && !stop_told_) {
        stop_told_ = true;
        const bool active_before = std::exchange(active_, false);
        if (!active_before) record_.begin(run_, false, {});
        tell("note", record_.finish_stopped(director_));
    }
}

void Session::go_away(Lanes& lanes) {
    const RunState state = director_.state();
    if (state == RunState::identify || state == RunState::ramp || state == RunState::run)
        director_.end(lanes);
    else
        done_ = !driving(state) && (state != RunState::tripped || stop_told_) && state != RunState::armed;
}

void Session::tidy(Take& take) const {
    if (record_.on()) return;
    double from_s = director_.now_s() - kept_s;
    if (director_.to_s() > director_.from_s()) from_s = std::min(from_s, director_.from_s() - 1);
    drop_before(take, from_s);
}

void Session::tell(std::string kind, const std::string& text) {
    changed_ = true;
    desk_.tell(director_.now_s(), std::move(kind), text);
}

void Session::publish() {
    auto state = std::make_shared<BenchState>();
    report_->fill(*state);
    state->answered = answered_;
    state->armed = armed_ && state->state == RunState::idle;
    state->facts = facts_;
    state->predicted = predicted_;
    state->response = response_;
    state->wanted = run_.drive;
    state->periods = run_.periods;
    state->settle = run_.settle;
    state->closed_loop = run_.closed_loop;
    state->record = recorded_;
    state->pictures = run_.pictures;
    state->trip_s = trip_s_;
    state->result = result_;
    state->not_reduced = not_reduced_;
    state->measured_from_s = measured_from_s_;
    state->points = points_;
    state->parts = parts_;
    state->mirror = mirror_;
    state->null = null_;
    state->mu = mu_;
    state->closed_form = closed_form_;
    state->recording = record_.state();
    state->limits = limits_;
    published_s_ = state->now_s;
    changed_ = false;
    desk_.publish(std::move(state));
}

}  // namespace shaker

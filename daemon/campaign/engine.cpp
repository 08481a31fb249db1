#include "daemon/campaign/engine.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <utility>

namespace shaker::campaign {

namespace {

constexpr int most_tries = 2;                // of a point
constexpr int most_returns = 3;              // without a pass between them
constexpr double identification_way = 0.01;  // m, that a walker may walk while the response is identified
constexpr double near_share = 0.4;           // of the whole way, in a narrow view

std::size_t side(double v) { return v < 0 ? 0 : 1; }

// During the identification the walker may cross the edge limit.
bool near_edge(const Seen& seen) {
    return std::min(seen.way[0], seen.way[1]) <
           std::min(identification_way, near_share * (seen.way[0] + seen.way[1]));
}

}  // namespace

Engine::Engine(std::vector<Point> points, const EngineSettings& settings, const std::vector<int>& ended,
               const std::vector<law::Point>& known)
    : points_{std::move(points)},
      over_(points_.size(), false),
      returns_by_{points_, settings.timing},
      settings_{settings},
      walks_{settings.mu, settings.g, settings.timing.settle_at_most} {
    for (const int id : ended) {
        const auto p = std::ranges::find(points_, id, &Point::id);
        if (p == points_.end()) continue;
        over_[static_cast<std::size_t>(p - points_.begin())] = true;
        ++ended_;
    }
    if (settings.mu_target > 0) choice_.emplace(settings.mu_target, settings.mu, settings.g);
    for (const law::Point& p : known)
        if (choice_) choice_->add(p);
    to_next();
}

void Engine::to_next() {
    begun_ = false;
    phase_ = Phase::between;
    at_ = choice_ ? choice_->next(points_, over_,
                                  [this](std::span<const Point* const> together) { return cost_s(together); })
                  : static_cast<std::size_t>(std::ranges::find(over_, false) - over_.begin());
}

double Engine::cost_s(std::span<const Point* const> points) {
    constexpr double recording_s = 3;  // to end one and to start the next
    const bool seen = std::isfinite(way_[0]);
    double place = seen ? (way_[0] - way_[1]) / 2 : 0, cost = 0;
    for (const Point* p : points) {
        const double frequency = p->asked.drive.frequency;
        const Walk walk = walks_.walk(p->asked.drive);
        const Walk back = walks_.walk(returns_by_.at(walk.v_D < 0 ? 1 : -1, frequency));
        const double free_way = way_[0] + way_[1] - kept_way(walk, back, settings_.timing, frequency);
        const Travel t = travel(p->asked, walk, settings_.timing, free_way);
        if (!t.fits()) return INFINITY;
        cost += lead(t, settings_.timing, free_way, place).bench_s();
        if (frequency != frequency_) cost += recording_s / static_cast<double>(points.size());
    }
    return cost;
}

const Point* Engine::point() const noexcept { return at_ < points_.size() ? &points_[at_] : nullptr; }

std::vector<Event> Engine::events() { return std::exchange(events_, {}); }

calibration::Estimate Engine::result(int point) const {
    const auto found = results_.find(point);
    return found == results_.end() ? calibration::Estimate{NAN, NAN} : found->second;
}

Action Engine::next(const Seen& seen) {
    if (done_) return {};
    x_m_ = seen.x_m;
    way_ = seen.way;
    if (way_back_.left()) way_back_.follow(seen.way.at(way_back_.ahead()));
    if (seen.state == run::RunState::tripped) {
        if (!std::exchange(tripped_, true)) {
            if (begun_) lost_ = "the drive tripped: " + seen.trip;
            pause("the drive has tripped: " + seen.trip + "; look at it, clear the trip, then resume");
        }
        if (!seen.pending) {
            take_loss();
            done_ = leaving_;
        }
        return {};
    }
    if (seen.state == run::RunState::idle) {
        tripped_ = false;
        if (phase_ != Phase::between && std::exchange(under_way_, false))
            lost_ = "the drive ended before the pass was complete";
        if (seen.pending) return {};
        take_loss();
        if (leaving_ || (stop_ && !begun_) || at_ == points_.size()) done_ = true;
        return paused_ || done_ ? Action{} : choose(seen);
    }
    const bool comes = run::driving(seen.state) || seen.state == run::RunState::armed;
    if (!comes || seen.state == run::RunState::ramp_down) return {};
    if (leaving_ || paused_) return halt(leaving_ ? "interrupted" : "paused");
    if (seen.state != run::RunState::run) return {};
    under_way_ = true;
    switch (phase_) {
        case Phase::measuring:
            return watch_pass(seen);
        case Phase::returning:
            return watch_return(seen);
        case Phase::between:
            break;
    }
    return choose(seen);
}

Action Engine::halt(const std::string& why) {
    if (phase_ == Phase::measuring) early_ = why;
    phase_ = Phase::between;
    under_way_ = false;
    return Stop{};
}

// Points that cannot be measured end here, so that the next one is chosen in the same step.
Action Engine::choose(const Seen& seen) {
    const bool idle = seen.state == run::RunState::idle;
    if (idle && !seen.may_start) return {};
    for (; at_ < points_.size() && (begun_ || !stop_); to_next()) {
        const Point& p = points_[at_];
        if (!begun_) {
            const Travel one = travel(p.asked, walks_.walk(p.asked.drive), settings_.timing, INFINITY);
            if (const std::string why = disk_is_short(seen, one); !why.empty()) {
                pause(why);
                return idle ? Action{} : halt({});
            }
            begin_point(p);
            begun_ = true;
        }
        PointSettings rest = p.asked;
        rest.precision = 0;
        rest.plan.periods = missing_periods();
        if (rest.plan.periods == 0) {
            end_point(Outcome::measured, missed_precision());
            continue;
        }
        const Walk walk = walks_.walk(p.asked.drive);
        const double frequency = p.asked.drive.frequency;
        const Walk back = walks_.walk(returns_by_.at(walk.v_D < 0 ? 1 : -1, frequency));
        const double kept = kept_way(walk, Walk{}, settings_.timing, frequency);
        const double ahead = seen.way[side(walk.v_D)] - kept;
        // A return ends a period of its own walk before the other edge.
        const double whole = seen.way[0] + seen.way[1] - kept_way(walk, back, settings_.timing, frequency);
        const Travel here = travel(rest, walk, settings_.timing, ahead);
        const Travel best = travel(rest, walk, settings_.timing, whole);
        if (!best.fits()) {
            end_point(Outcome::failed, best.why);
            continue;
        }
        const bool full = seen.recorded_s > settings_.timing.recording_s / 2 ||
                          seen.recorded_s + here.drive_s() > settings_.timing.recording_s;
        if (!idle && (p.asked.drive.frequency != frequency_ || full)) return halt({});
        frequency_ = p.asked.drive.frequency;
        if (!seen.identified && !idle) return halt({});  // the identification starts from rest
        if (!seen.identified && near_edge(seen) && !std::exchange(centred_, true))
            return lead_to_middle(seen, seen.way[1] < seen.way[0] ? 1 : -1);
        // Near the other edge a return cannot end in time.
        const double least_behind = settings_.timing.least * std::abs(back.v_D) / frequency;
        const bool room = seen.way[side(-walk.v_D)] > least_behind;
        if (!here.fits() || (here.passes > best.passes && returns_ == 0 && room)) {
            if (returns_++ < most_returns)
                return room ? lead_back(seen, walk.v_D, (seen.way[0] + seen.way[1] + kept + best.way) / 2)
                            : lead_to_middle(seen, -walk.v_D);
            end_point(Outcome::failed, "the walker used up its way while it settled");
            continue;
        }
        phase_ = Phase::measuring;
        early_.clear();
        taken_ = false;
        ++pass_;
        ordered_s_ = seen.now_s;
        x_from_m_ = seen.x_m;
        asked_periods_ = here.periods;
        return go(idle, p.asked.drive, {.plan = {here.periods, p.asked.plan.settle, 1}});
    }
    if (idle) {
        done_ = true;
        return {};
    }
    return halt({});
}

Action Engine::go(bool idle, const Drive& drive, const run::Task& task) {
    under_way_ = !idle;
    if (idle) return Start{drive, task};
    return Change{drive, task};
}

void Engine::begin_point(const Point& point) {
    tries_ = measured_ = returns_ = pass_ = 0;
    told_passes_.clear();
    passes_.clear();
    events_.push_back(PointBegun{.point = point.id});
}

// The walker has to have `target` of way ahead of it (m), in the direction of v_D.
Action Engine::lead_back(const Seen& seen, double v_D, double target) {
    const Drive back = returns_by_.at(v_D < 0 ? 1 : -1, frequency_);
    const Walk walk = walks_.walk(back);
    if (!walk.why.empty() || walk.v_D * v_D >= 0) {
        fail("no drive is known that leads the walker back");
        return seen.state == run::RunState::run ? halt({}) : Action{};
    }
    note_return();
    phase_ = Phase::returning;
    const std::size_t ahead = side(v_D);
    way_back_.begin(seen.now_s, seen.x_m, ahead, seen.way.at(ahead), target, std::abs(walk.v_D) / frequency_,
                    1 / frequency_);
    return go(seen.state == run::RunState::idle, back,
              {.plan = {.periods = 0}, .identifies = !near_edge(seen)});
}

// The edge in the direction `ahead` (+1, -1) is near.
Action Engine::lead_to_middle(const Seen& seen, double ahead) {
    return lead_back(seen, ahead, (seen.way[0] + seen.way[1]) / 2);
}

Action Engine::watch_return(const Seen& seen) {
    if (way_back_.arrives(seen.way)) {
        Seen turned = seen;
        double& way = turned.way.at(way_back_.ahead());
        way_back_.leave(seen.now_s, way);
        way = way_back_.expected();
        phase_ = Phase::between;
        const Action action = choose(turned);
        if (std::holds_alternative<Stop>(action)) way_back_.abandon();  // a ramp to rest takes another time
        return action;
    }
    if (!way_back_.late(seen.now_s)) return {};
    fail("the walker does not come back");
    return halt({});
}

Action Engine::watch_pass(const Seen& seen) {
    const Walk walk = walks_.walk(points_[at_].asked.drive);
    const double step = std::abs(walk.v_D) / frequency_;
    const std::size_t ahead = side(walk.v_D);
    if (seen.holding) {
        if (seen.pending) return {};
        if (!taken_) lose_pass("nothing was measured");
    } else {
        if (seen.way.at(ahead) > settings_.timing.least * step) return {};
        early_ = "the walker came near the edge of the picture";
    }
    phase_ = Phase::between;
    Seen turned = seen;  // where the walker is when another drive is in force
    turned.way.at(ahead) -= settings_.timing.runs_on * step;
    turned.way.at(1 - ahead) += settings_.timing.runs_on * step;
    return choose(turned);
}

// A measurement that a skipped point had under way belongs to no point.
void Engine::take(const on_call::Measured& measured) {
    const bool of_pass = begun_ && measured.measurement.part.from_s >= ordered_s_ &&
                         std::ranges::find(told_passes_, pass_) == told_passes_.end() &&
                         numbers_of(measured.measurement.asked) == numbers_of(points_[at_].asked.drive);
    if (!of_pass) return;
    taken_ = true;
    if (!measured.reduction) {
        end_pass(measured, PassEnded::How::failed, measured.not_reduced);
        return fail(measured.not_reduced);
    }
    const recording::MeasuredPart& part = measured.measurement.part;
    const int periods = static_cast<int>(std::lround((part.to_s - part.from_s) * frequency_));
    if (early_.empty() && periods < asked_periods_) early_ = lost_.empty() ? "the drive ended" : lost_;
    end_pass(measured, early_.empty() ? PassEnded::How::complete : PassEnded::How::early, early_);
    returns_ = 0;
    measured_ += periods;
    if (choice_) {
        law::Point pass = law::point_of(*measured.reduction, points_[at_].asked.drive);
        pass.number = points_[at_].id;
        pass.partner = points_[at_].partner;
        choice_->add(std::move(pass));
    }
    passes_.push_back({measured.reduction->v_D, periods});
}

void Engine::note_return() {
    if (!way_back_.left()) return;
    const on_call::WayBack::Done back = way_back_.end();
    events_.emplace_back(Returned{.point = points_[at_].id,
                                  .x_from_m = back.x_from_m,
                                  .x_asked_m = back.x_asked_m,
                                  .x_to_m = back.x_to_m,
                                  .for_s = back.for_s});
}

void Engine::end_pass(const on_call::Measured& measured, PassEnded::How how, std::string reason) {
    note_return();
    told_passes_.push_back(pass_);
    const recording::FinishedMeasurement& m = measured.measurement;
    events_.emplace_back(PassEnded{.point = points_[at_].id,
                                   .pass = pass_,
                                   .recording = std::filesystem::path{measured.recording}.stem().string(),
                                   .measurement = m.number,
                                   .from_s = m.part.from_s,
                                   .to_s = m.part.to_s,
                                   .x_from_m = x_from_m_,
                                   .x_to_m = x_m_,
                                   .true_v_D = measured.true_v_D,
                                   .how = how,
                                   .reason = std::move(reason)});
}

// The drive of the pass, or of the return, is over, and all that it measured is reduced.
void Engine::take_loss() {
    const std::string reason = std::exchange(lost_, {});
    if (reason.empty()) return;
    if (phase_ == Phase::measuring && taken_)
        phase_ = Phase::between;
    else
        lose_pass(reason);
}

// The pass under way has given no measurement.
void Engine::lose_pass(const std::string& reason) {
    if (phase_ == Phase::measuring) {
        note_return();
        told_passes_.push_back(pass_);
        events_.emplace_back(PassEnded{.point = points_[at_].id,
                                       .pass = pass_,
                                       .x_from_m = x_from_m_,
                                       .x_to_m = x_m_,
                                       .how = PassEnded::How::failed,
                                       .reason = reason});
    }
    fail(reason);
}

int Engine::missing_periods() const {
    const PointSettings& asked = points_[at_].asked;
    int wanted = asked.plan.periods;
    if (asked.precision > 0) {
        wanted = asked.least_periods;
        if (measured_ > 0)
            wanted = static_cast<int>(
                std::min(1.0 * asked.most_periods,
                         std::ceil(measured_ *
                                   std::pow(reduction::combined(passes_).v_D.sigma / asked.precision, 2))));
    }
    if (measured_ >= wanted) return 0;
    return std::max(wanted - measured_, std::min(least_pass_periods, wanted));
}

std::string Engine::missed_precision() const {
    const double asked = points_[at_].asked.precision, reached = reduction::combined(passes_).v_D.sigma;
    if (asked == 0 || reached <= asked) return {};
    return fmt::format(
        "the error of v_D is {:.3g} mm/s after {} periods, the most that the plan allows; "
        "{:.3g} mm/s was asked",
        1e3 * reached, measured_, 1e3 * asked);
}

void Engine::end_point(Outcome outcome, std::string reason) {
    const int id = points_[at_].id;
    if (outcome == Outcome::measured) {
        results_[id] = reduction::combined(passes_).v_D;
        walks_.add(points_[at_].asked.drive, results_[id]);
    }
    last_ = {id, std::exchange(told_passes_, {})};
    note_return();
    events_.push_back(PointEnded{id, outcome, std::move(reason)});
    over_[at_] = true;
    ++ended_;
}

void Engine::fail(const std::string& reason) {
    phase_ = Phase::between;
    if (++tries_ < most_tries) return;
    end_point(Outcome::failed, reason);
    to_next();
}

}  // namespace shaker::campaign

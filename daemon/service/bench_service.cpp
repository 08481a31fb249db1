#include "daemon/service/bench_service.hpp"

#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <exception>
#include <iterator>
#include <utility>

#include "daemon/recording/time_text.hpp"
#include "daemon/run/run_setup.hpp"
#include "daemon/service/outlook.hpp"
#include "daemon/service/state_builder.hpp"
#include "drivers/errors.hpp"
#include "drivers/walker/no_stick.hpp"

namespace shaker::service {

namespace {

constexpr double publish_s = 0.1;         // master time between two published states
constexpr std::size_t most_points = 500;  // published measurements

}  // namespace

BenchService::BenchService(run::Runner& runner, const BenchServiceSettings& settings, BenchPort& bench_port)
    : runner_{runner},
      bench_{runner.bench()},
      collector_{runner.collector()},
      bench_port_{bench_port},
      on_call_{runner, settings.beside},
      sequence_{runner.sequence()},
      record_{runner.recordings()},
      report_{std::make_unique<StateBuilder>(bench_, collector_, sequence_, bench_port.feed())},
      campaign_{runner, on_call_, settings.beside, settings.plans,
                [this](const std::string& text) { log("campaign", text); }},
      run_{runner.options()},
      opened_{run_.pictures},
      filed_limits_{on_call_.limits()},
      fits_mu_{settings.fits_mu},
      live_mu_{bench_.gravity, settings.beside},
      disk_{"disk", settings.beside} {
    disk_.grant();
    BenchFacts facts{.rig = bench_.rig.name,
                     .dac = bench_.rig.dac->info(),
                     .accelerometer = bench_.rig.accelerometer->info(),
                     .views = collector_.views(),
                     .soft_start_periods = sequence_.plan().soft_start,
                     .mu = settings.mu,
                     .gravity = bench_.gravity,
                     .simulated = bench_.world != nullptr};
    mu_ = facts.mu;
    facts_ = std::make_shared<const BenchFacts>(std::move(facts));
    predicted_ = run::run_demands(bench_, run_.drive, on_call_.limits());
    predict();
    acquisition::Channels& channels = collector_.channels();
    bench_port.stop_by([&channels] { return ++channels.aborts; },
                       [&channels] { return channels.aborts_answered.load(); });
}

BenchService::~BenchService() = default;

// The data come first, so that orders meet the state of now: an order given after a trip is refused. Outcomes
// come before the campaign's next order, which depends on them, and all orders before OnCall::follow(), which
// opens and ends their recordings. The states are followed last, so that the log has this step's changes, and
// then what ends by itself: a task, the way to the middle, a campaign, the program.
bool BenchService::step(const acquisition::Streams& streams, acquisition::Channels& channels) {
    const bool any = on_call_.take(streams, channels);
    report_->feed(streams);
    answer(channels);
    take_outcome();
    campaign_.order(channels);
    if (const std::uint64_t vain = channels.lost.not_learned; std::exchange(not_learned_, vain) != vain)
        log("note",
            "a camera's targets were not at their last positions at the start of the recording; a replay "
            "that tracks its pictures starts from other positions");
    log_not_found();
    log_warnings(channels);
    const bool waits = record_.preparing();
    on_call_.follow(run_, channels);
    if (waits && record_.on()) {
        name_.clear();
        log("note", "the run is recorded from now on: " + record_.name());
    }
    follow_states();
    follow_task(channels);
    follow_to_middle(channels);
    follow_campaign();
    if (leaving_) go_away(channels);
    const double now_s = sequence_.now_s();
    if (changed_ || now_s >= published_s_ + publish_s) publish();
    return any;
}

void BenchService::take_outcome() {
    while (const auto m = on_call_.measured()) {
        changed_ = true;
        campaign_.take(*m);
        const recording::MeasuredPart& part = m->measurement.part;
        measured_from_s_ = part.from_s;
        add_row(catalogue::row_of(m->measurement, m->reduction.get(), m->not_reduced,
                                  sequence_.plan().task.plan.periods),
                part.to_s, m->recording);
        if (m->reduction == nullptr) {
            not_reduced_ = m->not_reduced;
            log("note", "a measurement could not be reduced: " + not_reduced_);
            continue;
        }
        for (const std::string& doubt : doubts_of(*m->reduction))
            if (warned_.insert(doubt.substr(0, doubt.find_first_of("0123456789"))).second)
                log("warning", fmt::format("measurement from {:.3f} s: {}", part.from_s, doubt));
        result_ = m->reduction;
        origin_ = {origin_.number + 1, m->measurement.asked, part.from_s, part.to_s};
        const law::Point point = law::point_of(*result_, m->measurement.asked);
        friction_ = law::friction_by_velocity({&point, 1}, bench_.gravity, point.tilt, "by gravity");
        not_reduced_.clear();
        if (points_.size() == most_points) {
            points_.erase(points_.begin());
            parts_.erase(parts_.begin());
        }
        points_.push_back({m->measurement.asked, result_->gamma, result_->phi, result_->v_D});
        parts_.push_back(part);
        if (fits_mu_) live_mu_.add(*result_, m->measurement.asked);
        compare_points();
    }
    if (live_mu_.follow()) compare_points();
}

void BenchService::add_row(catalogue::ResultRow row, double ended_s, const std::string& file) {
    row.time = run_.threads ? recording::utc_text_ago(sequence_.now_s() - ended_s)
                            : recording::utc_text(recording::time_text_after(recording::epoch_text, ended_s));
    row.recording = file;
    bench_port_.results().add({std::move(row)});
}

// Compares the newest point with its mirror point, and all points with the closed form without stick.
void BenchService::compare_points() {
    mirror_ = mirror_pair(points_);
    if (const auto null = null_phase(points_)) null_ = null;
    if (const auto fit = live_mu_.to_predict();
        std::isfinite(fit.value) && !(live_mu_.mu().refused && mu_given_))
        mu_ = fit;
    predict();
    closed_form_.clear();
    for (const reduction::DrivenPoint& p : points_) {
        Drive measured = p.asked;
        measured.gamma = p.gamma.value;
        measured.phi = p.phi.value;
        closed_form_.push_back(
            std::isfinite(mu_.value)
                ? walker::no_stick(harmonics(measured), measured.frequency, mu_.value, bench_.gravity).v_D
                : NAN);
    }
}

void BenchService::follow_states() {
    const run::RunState state = sequence_.state();
    for (; logged_notes_ < sequence_.notes().size(); ++logged_notes_)
        log("note", sequence_.notes()[logged_notes_]);
    const bool changed = std::exchange(state_, state) != state;
    const bool was_finishing = shown_ == run::RunState::finishing;
    if (const run::RunState shown = on_call_.state(); std::exchange(shown_, shown) != shown) {
        log("state", name(shown));
        if (was_finishing) finished_s_ = sequence_.now_s();
    }
    if (changed) {
        if (driving(state) || state == run::RunState::tripped) armed_ = false;
        response_ =
            sequence_.controller().identified()
                ? std::make_shared<const control::IdentifiedResponse>(*sequence_.controller().identified())
                : nullptr;
        if (state == run::RunState::tripped) {
            trip_s_ = sequence_.now_s();
            trip_file_.clear();
            log("trip", text(*sequence_.trip()), name(sequence_.trip()->cause));
            if (sequence_.stops().at(sequence_.cause()).measuring)
                add_row(catalogue::interrupted_row(run_.drive, finding(*sequence_.trip())), trip_s_,
                        record_.name());
        }
    }
    while (const auto run = on_call_.finished()) {
        campaign_.take(*run);
        log_finished(*run);
    }
}

void BenchService::predict() { walk_ = run::predict_walk(run_.drive, points_, mu_, bench_.gravity); }

// The drive is silent again after the measurements that were asked for, or that fit.
void BenchService::follow_task(acquisition::Channels& channels) {
    if (to_middle_.active() || campaign_.active() || sequence_.plan().task.plan.measurements == 0) return;
    std::string end = on_call_.way_ends();
    if (sequence_.holding()) end = fmt::format("{} measurements are complete", sequence_.measured().size());
    if (end.empty()) return;
    log("note", end);
    sequence_.end(channels);
}

void BenchService::follow_to_middle(acquisition::Channels& channels) {
    if (!to_middle_.active()) return;
    const double edge_mm = on_call_.limits().edge_mm;
    switch (sequence_.state()) {
        case run::RunState::tripped:
            to_middle_.give_up();
            changed_ = true;
            break;
        case run::RunState::idle:
            log("note", to_middle_.end(sequence_.walker(), edge_mm));
            break;
        case run::RunState::run:
            if (to_middle_.over(sequence_.now_s(), sequence_.walker(), edge_mm)) sequence_.end(channels);
            break;
        default:
            break;
    }
}

// The set-point of the bench is that of the campaign.
void BenchService::follow_campaign() {
    const bool was_active = campaign_.active();
    campaign_.follow(leaving_);
    changed_ = changed_ || campaign_.active() != was_active;
    if (!campaign_.active() || run_.drive == campaign_.drive()) return;
    run_.drive = campaign_.drive();
    predicted_ = run::run_demands(bench_, run_.drive, on_call_.limits());
    predict();
    changed_ = true;
}

void BenchService::log_finished(const run::FinishedRun& run) {
    if (run.failure) try {
            std::rethrow_exception(run.failure);
        } catch (const std::exception& e) {
            return log("note",
                       fmt::format("{0} could not be finished: {1}; {2}", run.file.string(), e.what(),
                                   run.data ? fmt::format("\"shakerd recover {}\" saves the data that "
                                                          "were written",
                                                          run.file.string())
                                            : "nothing was written"));
        }
    if (state_ == run::RunState::tripped) trip_file_ = run.file.filename().string();
    if (run.whole) return log("note", "recorded: " + run.file.string());
    log("note", fmt::format("last {} s of the stopped run: {}", acquisition::tail_s, run.file.string()));
}

// Logs once that a camera's targets are not found at the start, and once that they are.
void BenchService::log_not_found() {
    not_found_.resize(bench_.rig.cameras.size());
    for (std::size_t i = 0; i < not_found_.size(); ++i) {
        const std::string& why = collector_.newest(i).not_found;
        if (why.empty() == not_found_[i].empty()) continue;
        not_found_[i] = why;
        const std::string found = "camera \"" + collector_.views()[i].camera + "\": its targets are found";
        why.empty() ? log("note", found) : log("warning", why + "; " + acquisition::way_to_targets);
    }
}

// Logs each cause once per run, as soon as it occurs.
void BenchService::log_warnings(const acquisition::Channels& channels) {
    for (std::size_t i = 0; i < safety::causes; ++i) {
        const std::uint64_t n = channels.warnings[static_cast<safety::Cause>(i)];
        if (std::exchange(warnings_[i], n) == n) continue;
        for (const std::string& text : record_.warnings()) {
            const std::string cause = text.substr(text.find(": ") + 2);
            if (warned_.insert(cause).second) log("warning", text);
        }
        return;
    }
}

void BenchService::go_away(acquisition::Channels& channels) {
    const run::RunState state = on_call_.state();
    if (state == run::RunState::armed || (driving(state) && state != run::RunState::ramp_down))
        on_call_.end(channels);
    else
        done_ = on_call_.at_rest() && campaign_.at_rest();
}

void BenchService::log(const std::string& kind, const std::string& text, std::string key) {
    changed_ = true;
    bench_port_.log(sequence_.now_s(), kind, text, std::move(key));
}

void BenchService::publish() {
    auto state = std::make_shared<BenchState>();
    report_->fill(*state, on_call_.limits());
    state->state = on_call_.state();
    state->since_s = std::max(state->since_s, finished_s_);
    state->answered = answered_;
    state->orders_wait = !waiting_.empty();
    state->armed = armed_ && state->state == run::RunState::idle;
    state->facts = facts_;
    state->predicted = predicted_;
    state->response = response_;
    state->to_middle = to_middle_.active();
    state->campaign = campaign_.state();
    state->plan_check = campaign_.checked();
    state->plans = campaign_.plans(sequence_.now_s());
    state->wanted = run_.drive;
    state->plan = run_.plan;
    state->closed_loop = run_.closed_loop;
    state->record = recorded_;
    state->record_name = name_;
    state->pictures = run_.pictures;
    state->trip_s = trip_s_;
    state->trip_file = trip_file_;
    if (!state->trip)
        trip_pictures_.clear();
    else if (trip_pictures_.empty())
        trip_pictures_ = state->pictures_now;
    state->trip_pictures = trip_pictures_;
    state->result = result_;
    state->result_origin = origin_;
    state->friction = friction_;
    state->not_reduced = not_reduced_;
    state->measured_from_s = measured_from_s_;
    state->points = points_;
    state->parts = parts_;
    state->mirror = mirror_;
    state->null = null_;
    state->mu = mu_;
    state->fitted_mu = live_mu_.mu();
    state->closed_form = closed_form_;
    state->recording = {record_.name(),        record_.finishing(),  record_.backlog(),
                        record_.pieces_lost(), record_.free_bytes(), room_bytes(record_.free_bytes()),
                        record_.rate()};
    state->real_time = runner_.real_time();
    state->real_time.insert(state->real_time.end(), grants_.begin(), grants_.end());
    state->may_clear = on_call_.may_clear();
    state->gauges = report_->gauges(predicted_, state->limits);
    state->outlook = outlook(*state, walk_, opened_);
    if (driving(state->state) && !state->to_middle) state->progress = progress_of(*state, sequence_);
    published_s_ = state->now_s;
    changed_ = false;
    bench_port_.publish(std::move(state));
}

}  // namespace shaker::service

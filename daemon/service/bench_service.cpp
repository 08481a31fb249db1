#include "daemon/service/bench_service.hpp"

#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <iterator>
#include <utility>

#include "daemon/reduction/no_stick.hpp"
#include "daemon/run/run_setup.hpp"
#include "daemon/service/state_builder.hpp"
#include "drivers/errors.hpp"

namespace shaker::service {

namespace {

constexpr double publish_s = 0.1;         // master time between two published states
constexpr double kept_s = 12;             // length of streams kept in memory
constexpr std::size_t most_points = 500;  // published measurements

}  // namespace

BenchService::BenchService(run::Runner& runner, const BenchServiceSettings& settings, BenchPort& bench_port)
    : runner_{runner},
      bench_{runner.bench()},
      collector_{runner.collector()},
      run_{runner.options()},
      opened_{run_.pictures},
      beside_{settings.beside},
      bench_port_{bench_port},
      limits_{runner.limits()},
      filed_limits_{limits_},
      sequence_{runner.sequence()},
      record_{runner.recordings()},
      report_{std::make_unique<StateBuilder>(bench_, collector_, sequence_, bench_port.feed())} {
    BenchFacts facts{.rig = bench_.rig.name,
                     .dac = bench_.rig.dac->info(),
                     .accelerometer = bench_.rig.accelerometer->info(),
                     .views = {},
                     .soft_start_periods = sequence_.plan().soft_start,
                     .recordings = record_.folder(),
                     .mu = settings.mu};
    for (const auto& camera : bench_.rig.cameras) facts.views.push_back(camera->view());
    mu_ = facts.mu;
    facts_ = std::make_shared<const BenchFacts>(std::move(facts));
    predicted_ = run::run_demands(bench_, run_.drive, limits_);
    if (bench_.world) bench_.world->keep_truth_for(kept_s);
    acquisition::Channels& channels = collector_.channels();
    bench_port.stop_by([&channels] { return ++channels.aborts; },
                       [&channels] { return channels.aborts_answered.load(); });
}

BenchService::~BenchService() = default;

bool BenchService::step(const acquisition::Streams& streams, acquisition::Channels& channels) {
    const bool any = sequence_.step(streams, channels);
    report_->feed(streams);
    measure(streams);  // before an order changes the set-point
    answer(channels);
    take_outcome();
    if (const std::uint64_t vain = channels.lost.not_learned; std::exchange(not_learned_, vain) != vain)
        log("note",
            "a camera's targets were not at their last positions at the start of the recording; a replay "
            "that tracks its pictures starts from other positions");
    record_.update(sequence_, channels);
    log_warnings(channels);
    follow_states();
    if (leaving_) go_away(channels);
    const double now_s = sequence_.now_s();
    if (changed_ || now_s >= published_s_ + publish_s) publish();
    tidy(collector_.streams());
    return any;
}

void BenchService::measure(const acquisition::Streams& streams) {
    const std::vector<recording::FinishedMeasurement>& all = sequence_.measured();
    for (; measured_ < all.size(); ++measured_) {
        const recording::MeasuredPart part = all[measured_].part;
        const double f = Synthesiser::realised(run_.drive.frequency, streams.dac_rate_hz);
        auto work = [m = measurement_of(streams, f, part.from_s, part.to_s),
                     warnings = record_.warnings()]() mutable -> Outcome {
            try {
                reduction::Reduction r = reduce(std::move(m));
                std::ranges::move(warnings, std::back_inserter(r.notes));
                return std::make_shared<const reduction::Reduction>(std::move(r));
            } catch (const std::exception& e) {  // the bench stays on call, whatever failed
                return std::string{e.what()};
            }
        };
        const auto policy = beside_ ? std::launch::async : std::launch::deferred;
        pending_.push_back({run_.drive, part, std::async(policy, std::move(work))});
    }
}

void BenchService::take_outcome() {
    while (!pending_.empty()) {
        Pending& p = pending_.front();
        if (p.outcome.wait_for(std::chrono::seconds{0}) == std::future_status::timeout) return;
        const Outcome outcome = p.outcome.get();
        changed_ = true;
        measured_from_s_ = p.part.from_s;
        if (const auto* why = std::get_if<std::string>(&outcome)) {
            not_reduced_ = *why;
            log("note", "a measurement could not be reduced: " + *why);
        } else {
            result_ = std::get<std::shared_ptr<const reduction::Reduction>>(outcome);
            origin_ = {origin_.number + 1, p.asked, p.part.from_s, p.part.to_s};
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

// Compares the newest point with its mirror point, and all points with the closed form without stick.
void BenchService::compare_points() {
    mirror_ = mirror_pair(points_);
    if (const auto null = null_phase(points_, bench_.gravity)) null_ = null;
    if (null_ && std::isfinite(null_->mu.value)) mu_ = null_->mu;
    closed_form_.clear();
    for (const reduction::DrivenPoint& p : points_) {
        Drive measured = p.asked;
        measured.gamma = p.gamma.value;
        measured.phi = p.phi.value;
        closed_form_.push_back(
            std::isfinite(mu_.value)
                ? reduction::no_stick(harmonics(measured), measured.frequency, mu_.value, bench_.gravity).v_D
                : NAN);
    }
}

// A run that has just ended is in the recorder's hands before the next state is published as idle.
run::RunState BenchService::shown_state() const {
    const run::RunState state = sequence_.state();
    const bool busy = record_.finishing() || (active_ && record_.on());
    return state == run::RunState::idle && busy ? run::RunState::finishing : state;
}

void BenchService::follow_states() {
    const run::RunState state = sequence_.state();
    for (; logged_notes_ < sequence_.notes().size(); ++logged_notes_)
        log("note", sequence_.notes()[logged_notes_]);
    const bool changed = std::exchange(state_, state) != state;
    if (changed && state == run::RunState::idle && std::exchange(active_, false)) record_.finish(sequence_);
    const bool was_finishing = shown_ == run::RunState::finishing;
    if (const run::RunState shown = shown_state(); std::exchange(shown_, shown) != shown) {
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
            log("trip", text(*sequence_.trip()), name(sequence_.trip()->cause));
        }
    }
    if (sequence_.may_clear() && recorded_stop_ != sequence_.cause()) {
        recorded_stop_ = sequence_.cause();
        const bool active_before = std::exchange(active_, false);
        if (!active_before) record_.begin(run_, {}, sequence_.now_s());
        record_.finish(sequence_);
    }
    while (const auto run = record_.finished()) log_finished(*run);
}

void BenchService::log_finished(const run::FinishedRun& run) {
    if (run.failure) try {
            std::rethrow_exception(run.failure);
        } catch (const std::exception& e) {
            const bool data = std::filesystem::exists(run.file.string() + ".part");
            return log("note", fmt::format("{0} could not be finished: {1}; {2}", run.file.string(), e.what(),
                                           data ? fmt::format("\"shakerd recover {}\" saves the data that "
                                                              "were written",
                                                              run.file.string())
                                                : "nothing was written"));
        }
    if (run.whole) return log("note", "recorded: " + run.file.string());
    log("note", fmt::format("last {} s of the stopped run: {}", acquisition::tail_s, run.file.string()));
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
    const run::RunState state = sequence_.state();
    if (driving(state) && state != run::RunState::ramp_down)
        sequence_.end(channels);
    else
        done_ = !record_.finishing() && !driving(state) &&
                (state != run::RunState::tripped || recorded_stop_ == sequence_.cause()) &&
                state != run::RunState::armed;
}

// Keeps the last seconds and the measurement that is not finished. Finished ones are in the recording.
void BenchService::tidy(acquisition::Streams& streams) const {
    const recording::MeasuredPart part{sequence_.from_s(), sequence_.to_s()};
    const std::vector<recording::FinishedMeasurement>& done = sequence_.measured();
    const bool open = part.to_s > part.from_s && (done.empty() || done.back().part != part) &&
                      sequence_.now_s() < part.to_s + kept_s;
    const double from_s = sequence_.now_s() - kept_s;
    drop_before(streams, open ? std::min(from_s, part.from_s - 1) : from_s);
}

void BenchService::log(const std::string& kind, const std::string& text, std::string key) {
    changed_ = true;
    bench_port_.log(sequence_.now_s(), kind, text, std::move(key));
}

void BenchService::publish() {
    auto state = std::make_shared<BenchState>();
    report_->fill(*state);
    state->state = shown_state();
    state->since_s = std::max(state->since_s, finished_s_);
    state->answered = answered_;
    state->armed = armed_ && state->state == run::RunState::idle;
    state->facts = facts_;
    state->predicted = predicted_;
    state->response = response_;
    state->wanted = run_.drive;
    state->periods = run_.periods;
    state->settle = run_.settle;
    state->closed_loop = run_.closed_loop;
    state->record = recorded_;
    state->record_name = name_;
    state->pictures = run_.pictures;
    state->trip_s = trip_s_;
    state->result = result_;
    state->result_origin = origin_;
    state->not_reduced = not_reduced_;
    state->measured_from_s = measured_from_s_;
    state->points = points_;
    state->parts = parts_;
    state->mirror = mirror_;
    state->null = null_;
    state->mu = mu_;
    state->closed_form = closed_form_;
    state->recording = {record_.name(), record_.finishing(), record_.backlog(), record_.pieces_lost(),
                        record_.free_bytes()};
    state->real_time = runner_.real_time();
    state->real_time.insert(state->real_time.end(), grants_.begin(), grants_.end());
    state->may_clear = sequence_.may_clear() && !record_.finishing();
    state->limits = limits_;
    published_s_ = state->now_s;
    changed_ = false;
    bench_port_.publish(std::move(state));
}

}  // namespace shaker::service

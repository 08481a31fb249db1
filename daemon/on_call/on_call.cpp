#include "daemon/on_call/on_call.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <iterator>
#include <utility>
#include <vector>

#include "daemon/run/run_setup.hpp"
#include "drivers/errors.hpp"

namespace shaker::on_call {

namespace {

constexpr double degree = two_pi / 360;
constexpr double kept_s = 12;  // length of streams kept in memory

}  // namespace

OnCall::OnCall(run::Runner& runner, bool beside)
    : runner_{runner},
      bench_{runner.bench()},
      collector_{runner.collector()},
      sequence_{runner.sequence()},
      record_{runner.recordings()},
      reducer_{"reduction", beside},
      limits_{runner.limits()},
      frequency_{runner.options().drive.frequency} {
    reducer_.grant();
    if (bench_.world) bench_.world->keep_truth_for(kept_s);
}

bool OnCall::take(const acquisition::Streams& streams, acquisition::Channels& channels) {
    const bool any = sequence_.step(streams, channels);
    go_on_with_start(channels);
    reduce_finished(streams);  // before an order changes the set-point
    return any;
}

void OnCall::follow(const run::RunOptions& run, acquisition::Channels& channels) {
    reduce_finished(collector_.streams());  // an order may have ended a measurement
    join_recording(channels);
    record_.update(sequence_, channels);
    const run::RunState state = sequence_.state();
    const bool changed = std::exchange(state_, state) != state;
    if (changed && state == run::RunState::idle && std::exchange(active_, false)) record_.finish(sequence_);
    if (sequence_.may_clear() && recorded_stop_ != sequence_.cause()) {
        recorded_stop_ = sequence_.cause();
        if (!std::exchange(active_, false)) record_.begin(run, {}, sequence_.now_s());
        record_.finish(sequence_);
    }
    tidy();
}

void OnCall::reduce_finished(const acquisition::Streams& streams) {
    const std::vector<recording::FinishedMeasurement>& all = sequence_.measured();
    for (; reduced_ < all.size(); ++reduced_) {
        const recording::MeasuredPart part = all[reduced_].part;
        const double f = Synthesiser::realised(all[reduced_].asked.frequency, streams.dac_rate_hz);
        std::vector<std::string> remarks = record_.warnings();
        if (std::string doubt = sequence_.mains_doubt(all[reduced_].asked); !doubt.empty())
            remarks.push_back(std::move(doubt));
        auto work = [m = measurement_of(streams, f, part.from_s, part.to_s),
                     remarks = std::move(remarks)]() mutable -> Outcome {
            try {
                reduction::Reduction r = reduce(std::move(m));
                std::ranges::move(remarks, std::back_inserter(r.notes));
                set_doubts(r);
                return std::make_shared<const reduction::Reduction>(std::move(r));
            } catch (const std::exception& e) {  // the bench stays on call, whatever failed
                return std::string{e.what()};
            }
        };
        Measured m;
        m.measurement = all[reduced_];
        if (record_.on()) m.recording = record_.name();
        if (bench_.world) m.true_v_D = drift_velocity(bench_.world->truth(0), part.from_s, part.to_s, f);
        pending_.push_back({std::move(m), reducer_.run(std::move(work))});
    }
}

std::optional<Measured> OnCall::measured() {
    if (pending_.empty()) return std::nullopt;
    Pending& first = pending_.front();
    if (!is_ready(first.outcome)) return std::nullopt;
    Measured m = std::move(first.measured);
    const Outcome outcome = first.outcome.get();
    if (const auto* why = std::get_if<std::string>(&outcome))
        m.not_reduced = *why;
    else
        m.reduction = std::get<std::shared_ptr<const reduction::Reduction>>(outcome);
    pending_.pop_front();
    return m;
}

void OnCall::require_possible(const Drive& drive, const safety::Limits& limits) const {
    require_allowed("frequency", drive.frequency, drive_limits.frequency, " Hz");
    require_allowed("gamma", drive.gamma, drive_limits.gamma, " g", paper_g);
    require_allowed("rho", drive.rho, drive_limits.rho);
    require_allowed("phi", drive.phi, drive_limits.phi, " deg", degree);
    for (const std::complex<double>& share : drive.overtones)
        require_allowed("share of an overtone", std::abs(share), drive_limits.share, " of gamma");
    run::require_seen(bench_, drive);
    safety::require_within(run::run_demands(bench_, drive, limits), drive.gamma);
}

void OnCall::may_drive(const run::RunOptions& run, const char* what,
                       const acquisition::Channels& channels) const {
    require_possible(run.drive, limits_);
    runner_.require_commissioned();
    runner_.require_real_time();
    for (std::size_t i = 0; i < bench_.rig.cameras.size(); ++i)
        if (const std::string& why = collector_.newest(i).not_found; !why.empty())
            throw InputError{fmt::format("{} cannot start: {}; {}", what, why, acquisition::way_to_targets)};
    sequence_.require_idle(what, channels);
}

void OnCall::require_idle(const char* what, const acquisition::Channels& channels) const {
    if (opening())
        throw InputError{
            fmt::format("{} cannot start while the recording of another run is being opened; wait until it "
                        "is, or stop it",
                        what)};
    sequence_.require_idle(what, channels);
}

void OnCall::note_drive(const Drive& drive) {
    frequency_ = drive.frequency;
    active_ = true;
    ++runs_;
    reduced_ = 0;
}

void OnCall::begin(const run::RunOptions& run, const run::Task& task, const std::filesystem::path& file,
                   const std::optional<run::PredictedWalk>& walk, acquisition::Channels& channels) {
    require_idle("a run", channels);
    may_drive(run, "a run", channels);
    static_cast<void>(walk_from_the_edge(run.drive, walk));
    if (!file.empty()) record_.prepare(run, file, sequence_.now_s(), run::Recordings::For::start);
    start_ = Start{run, task, walk, !file.empty(), channels.aborts};
    go_on_with_start(channels);
}

void OnCall::go_on_with_start(acquisition::Channels& channels) {
    if (!opening()) return;
    const bool aborted = channels.aborts != start_->aborts;  // then nobody waits for the disk
    if (start_->recorded && record_.opening() && !aborted) return;
    start_->over = true;
    try {
        drive(*start_, channels);
    } catch (...) {
        start_->failure = std::current_exception();
        if (record_.preparing()) record_.discard();
    }
}

// The bench may have changed while the file was opened.
void OnCall::drive(Start& start, acquisition::Channels& channels) {
    const run::RunOptions& run = start.run;
    may_drive(run, "a run", channels);
    if (channels.aborts != start.aborts)
        throw InputError{"an abort came before the drive began; start again if it is still wanted"};
    const auto permit = walk_from_the_edge(run.drive, start.walk);
    if (start.recorded)
        record_.begin_prepared();
    else
        record_.begin(run, {}, sequence_.now_s());
    note_drive(run.drive);
    if (start.walk) start.fits = run::what_fits(*start.walk, sequence_.walker(), limits_.edge_mm, run.drive);
    // Throws after an abort in this moment; its trip then ends the recording.
    sequence_.begin(run.drive, start.task, channels, permit);
}

std::optional<std::string> OnCall::begun() {
    if (!start_ || !start_->over) return std::nullopt;
    const Start start = *std::exchange(start_, std::nullopt);
    if (start.failure) std::rethrow_exception(start.failure);
    return start.fits;
}

void OnCall::end(acquisition::Channels& channels) {
    if (!opening()) return sequence_.end(channels);
    start_->over = true;
    start_->failure = std::make_exception_ptr(InputError{"the run was stopped before its drive began"});
    record_.discard();
}

void OnCall::identify(const run::RunOptions& run, acquisition::Channels& channels) {
    require_idle("identification", channels);
    may_drive(run, "identification", channels);
    if (const auto edge_mm = sequence_.walker().mean_edge_mm())
        require_inside(*edge_mm, "bring it to the middle first");
    record_.begin(run, {}, sequence_.now_s());
    note_drive(run.drive);
    sequence_.identify(run.drive, channels);
}

void OnCall::set(const Drive& drive, const run::Task& task, acquisition::Channels& channels) {
    require_possible(drive, limits_);
    if ((record_.on() || record_.preparing()) && drive.frequency != frequency_)
        throw InputError{"the frequency cannot change during a recorded run; stop the run first"};
    sequence_.set(drive, task, channels);
    frequency_ = drive.frequency;
}

void OnCall::record(const run::RunOptions& run, const std::filesystem::path& file) {
    if (recorded::keeps_all(run.pictures))
        throw InputError{
            fmt::format("pictures \"{}\" can be recorded only from the start of a run; choose "
                        "\"first-second\" or \"off\", "
                        "or stop the drive first",
                        name(run.pictures))};
    record_.prepare(run, file, sequence_.now_s(), run::Recordings::For::run_under_way);
}

void OnCall::end_recording() {
    record_.discard();
    reduce_finished(collector_.streams());  // they are of this recording
    if (record_.on()) record_.finish(sequence_);
}

// The drive settles again at its set-point, so that no measurement begins before the recording.
void OnCall::join_recording(acquisition::Channels& channels) {
    if (!record_.preparing() || opening()) return;
    const run::RunState state = sequence_.state();
    if (!run::driving(state) || state == run::RunState::ramp_down) return record_.discard();
    if (!record_.prepared() || !sequence_.may_set() || sequence_.holding()) return;
    run::Task task = sequence_.plan().task;
    if (task.plan.measurements > 0) task.plan.measurements = sequence_.left();
    sequence_.set(sequence_.controller().drive(), task, channels);
    reduce_finished(collector_.streams());
    record_.join(sequence_);
}

void OnCall::clear(std::size_t shown, std::uint64_t aborts, acquisition::Channels& channels) {
    if (shown != sequence_.stops().size() && sequence_.state() == run::RunState::tripped)
        throw InputError{"a trip came after this clear; look at its cause, then clear it"};
    if (record_.finishing())
        throw InputError{
            "the recording of the stopped run is still being finished; wait, then clear the trip"};
    sequence_.clear(aborts, channels);
}

void OnCall::hold_to(const safety::Limits& limits, acquisition::Channels& channels) {
    const auto detectors = limits_.detectors;
    limits_ = limits;
    limits_.detectors = detectors;
    sequence_.hold_to(limits_, channels);
}

// A run that has just ended is in the recorder's hands before its state counts as idle.
run::RunState OnCall::state() const {
    const run::RunState state = sequence_.state();
    if (opening() && state == run::RunState::idle) return run::RunState::armed;
    const bool busy = record_.finishing() || (active_ && record_.on());
    return state == run::RunState::idle && busy ? run::RunState::finishing : state;
}

bool OnCall::at_rest() const {
    const run::RunState state = sequence_.state();
    return !record_.finishing() && !opening() && !run::driving(state) &&
           (state != run::RunState::tripped || recorded_stop_ == sequence_.cause()) &&
           state != run::RunState::armed;
}

void OnCall::require_inside(double edge_mm, const std::string& way_back) const {
    if (edge_mm >= limits_.edge_mm) return;
    throw InputError{fmt::format("the walker is {:.1f} mm from the edge of the picture (at least {} mm); {}",
                                 edge_mm, limits_.edge_mm, way_back)};
}

std::string OnCall::way_ends() const {
    const MeasurementPlan& plan = sequence_.plan().task.plan;
    const run::WalkerMonitor& walker = sequence_.walker();
    const auto drift_m = walker.drift_m();
    if (sequence_.left() <= 0 || !sequence_.may_set() || !drift_m) return {};
    const double left = run::periods_to_edge(walker.ways_m(limits_.edge_mm), *drift_m, walker.swing_m());
    const double unseen = (sequence_.now_s() - walker.until_s()) * frequency_;
    // The mean place is half a period old. A soft stop takes half of its length at the full speed.
    const double stopping = unseen + 1 + run::soft_stop_s(sequence_.plan(), frequency_) * frequency_ / 2;
    const std::size_t whole = sequence_.measured().size();
    const std::string to_do = "bring the walker to the middle, or try phi + 180 deg";
    if (left < stopping && sequence_.measuring())
        return fmt::format(
            "stopped in measurement {} of {}, which keeps its whole periods: the walker is "
            "near the edge limit; {}",
            whole + 1, plan.measurements, to_do);
    const bool next = !sequence_.measuring() && whole > 0;
    if (left >= stopping + (next ? plan.periods + run::margin_periods : 0)) return {};
    return fmt::format("stopped after {} of {}: the next measurement would reach the edge limit; {}", whole,
                       plan.measurements, to_do);
}

double OnCall::oscillation_mm(const Drive& drive) const {
    return 1e3 * safety::largest_displacement(harmonics(drive), drive.frequency);
}

// A walker beyond the edge limit, or so near to it that its oscillation would cross it, may start if it will
// certainly walk inwards.
std::optional<safety::EdgePermit> OnCall::walk_from_the_edge(
    const Drive& drive, const std::optional<run::PredictedWalk>& walk) const {
    const run::WalkerMonitor& walker = sequence_.walker();
    const auto edge_mm = walker.mean_edge_mm();
    const double inside_mm = limits_.edge_mm + oscillation_mm(drive);
    if (!edge_mm || *edge_mm >= inside_mm) return std::nullopt;
    const double outer_mm = safety::EdgePermit::outer_limit_mm(sequence_.edge_trip_mm().value_or(*edge_mm));
    const bool inwards = walk && run::leads_towards(*walk, walker.inwards());
    if (inwards && *edge_mm >= outer_mm) return safety::EdgePermit{*edge_mm, inside_mm, outer_mm};
    std::string reason = *edge_mm < outer_mm ? "move it back by hand" : "bring it to the middle first";
    if (!walk)
        reason = "its direction cannot be predicted: give mu, or " + reason;
    else if (!inwards)
        reason = fmt::format("{} does not lead inwards by three times its error; try phi + 180 deg, or {}",
                             text(*walk), reason);
    require_inside(*edge_mm, reason);
    return std::nullopt;
}

// Keeps the last seconds and the measurement that is not finished. Finished ones are in the recording.
void OnCall::tidy() {
    const recording::MeasuredPart part{sequence_.from_s(), sequence_.to_s()};
    const std::vector<recording::FinishedMeasurement>& done = sequence_.measured();
    const bool open = part.to_s > part.from_s && (done.empty() || done.back().part != part) &&
                      sequence_.now_s() < part.to_s + kept_s;
    const double from_s = sequence_.now_s() - kept_s, begun_s = open ? part.from_s - 1 : from_s;
    drop_before(collector_.streams(), std::min(from_s, begun_s));
    if (bench_.world) bench_.world->keep_truth_for(std::max(kept_s, sequence_.now_s() - begun_s));
}

}  // namespace shaker::on_call

// The bench's orders: checks, refusals and execution.
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <future>
#include <iterator>
#include <memory>
#include <numbers>

#include "daemon/recording/recorder.hpp"
#include "daemon/run/run_setup.hpp"
#include "daemon/service/bench_service.hpp"
#include "daemon/service/made_order.hpp"
#include "daemon/service/outlook.hpp"
#include "daemon/service/pending_orders.hpp"
#include "daemon/service/state_builder.hpp"
#include "drivers/errors.hpp"

namespace shaker::service {

namespace {

constexpr int longest_measurement_s = 100;
constexpr std::size_t most_orders = 16;  // in a step
constexpr std::size_t most_held = 64;    // behind an order that waits; a stop behind them is still read

// Length of the view along the shaker's axis; NaN: not known.
double view_m(const WalkerState& walker) { return std::abs(walker.right_m - walker.left_m); }

std::string allowed_pictures(recorded::KeptPictures opened) {
    std::string words;
    for (std::size_t i = 0; i < recorded::kept_pictures_words.size(); ++i)
        if (recordable(static_cast<recorded::KeptPictures>(i), opened))
            words += fmt::format("{}\"{}\"", words.empty() ? "" : ", ", recorded::kept_pictures_words.at(i));
    return words + " are";
}

}  // namespace

// A program that ends starts, changes and clears nothing. An abort voids the orders that were waiting, but
// those that cannot lead to a drive.
void BenchService::require_possible(const Order& order) const {
    const orders::When& when = row_of(order.what).when;
    if (order.aborts != bench_port_.aborted() && !when.outlasts_abort)
        throw InputError{"an abort came after this order; give it again if it is still wanted"};
    if (leaving_ && when.may_drive)
        throw InputError{"the program is ending; give the order after its next start"};
    if (!when.not_in_campaign.empty()) campaign_.require_none(when.not_in_campaign);
}

// Orders are carried out in their order. A stop and a lower limit do not wait for the disk.
std::optional<Order> BenchService::next_order() {
    if (waiting_.empty() && !held_.empty()) {
        std::optional<Order> first{std::move(held_.front())};
        held_.pop_front();
        return first;
    }
    for (;;) {
        auto order = bench_port_.next();
        if (!order || waiting_.empty() || row_of(order->what).when.overtakes) return order;
        if (held_.size() < most_held) {
            held_.push_back(std::move(*order));
            continue;
        }
        ++answered_;
        if (order->answer) order->answer("too many orders wait for the disk; give it again in a moment");
    }
}

void BenchService::go_on(Answers& answers, acquisition::Channels& channels) {
    for (auto w = waiting_.begin(); w != waiting_.end();) {
        std::string refused;
        try {
            if (!w->second(channels)) {
                ++w;
                continue;
            }
        } catch (const std::exception& e) {
            refused = e.what();
        }
        answers.emplace_back(std::move(w->first), std::move(refused));
        w = waiting_.erase(w);
    }
}

template <>
void BenchService::obey(const SetDrive& order, acquisition::Channels& channels) {
    on_call_.require_possible(order.drive, on_call_.limits());
    const run::RunState state = on_call_.state();
    if (to_middle_.active())
        throw InputError{
            "the walker is being brought to the middle; wait until the bench is idle, or stop it, then "
            "set the drive"};
    if (state == run::RunState::run)
        on_call_.set(order.drive, sequence_.plan().task, channels);
    else if (driving(state) || state == run::RunState::armed)
        throw InputError{fmt::format(
            "the drive cannot be changed while the bench is {}; wait until it is running, or stop it",
            row_of(state).shown)};
    run_.drive = order.drive;
    predicted_ = run::run_demands(bench_, run_.drive, on_call_.limits());
    predict();
    armed_ = !driving(state);
}

void BenchService::forget_last_run() {
    warned_.clear();
    logged_notes_ = 0;
}

// An abort in this moment refuses a run that has begun; its trip then ends the recording.
void BenchService::begin_run(const run::RunOptions& run, const run::Task& task,
                             const std::filesystem::path& file, const std::optional<run::PredictedWalk>& walk,
                             acquisition::Channels& channels,
                             std::function<void(const std::string& fits)> then) {
    const std::uint64_t before = on_call_.runs();
    on_call_.begin(run, task, file, walk, channels);
    rest_ = [this, before, then = std::move(then)](acquisition::Channels& /*channels*/) {
        try {
            const std::optional<std::string> fits = on_call_.begun();
            if (!fits) return false;
            forget_last_run();
            then(*fits);
            return true;
        } catch (const std::exception&) {
            if (on_call_.runs() != before) forget_last_run();
            throw;
        }
    };
}

template <>
void BenchService::obey(const Begin& order, acquisition::Channels& channels) {
    run::RunOptions run = run_;
    run.drive = order.drive.value_or(run_.drive);
    for (const MeasurementField& field : measurement_fields) {
        const int value = order.plan.*field.member;
        Range allowed = field.allowed;
        if (field.member == &MeasurementPlan::periods)
            allowed.max = std::floor(longest_measurement_s * run.drive.frequency);
        require_allowed(field.key, value, allowed);
        run.plan.*field.member = field.lasts ? value : 0;
    }
    const auto file = recorded_ ? record_.file_named(name_) : std::filesystem::path{};
    const auto walk = run::predict_walk(run.drive, points_, mu_, bench_.gravity);
    const bool moves = order.drive.has_value();
    begin_run(run, {.plan = order.plan}, file, walk, channels, [this, run, moves](const std::string& fits) {
        run_.plan = run.plan;
        if (moves) {
            run_.drive = run.drive;
            predicted_ = run::run_demands(bench_, run_.drive, on_call_.limits());
            predict();
        }
        name_.clear();
        result_.reset();
        friction_ = {};
        not_reduced_.clear();
        if (!fits.empty()) log("note", fits);
    });
}

template <>
void BenchService::obey(const Identify& /*order*/, acquisition::Channels& channels) {
    const std::uint64_t before = on_call_.runs();
    try {
        on_call_.identify(run_, channels);
    } catch (const std::exception&) {
        if (on_call_.runs() != before) forget_last_run();
        throw;
    }
    forget_last_run();
}

template <>
void BenchService::obey(const BringToMiddle& /*order*/, acquisition::Channels& channels) {
    on_call_.require_idle("bringing the walker to the middle", channels);
    const on_call::ToMiddle::Way way = on_call::ToMiddle::way(
        sequence_.walker(), on_call_.limits().edge_mm, run_.drive.frequency, points_, mu_, bench_.gravity,
        [this](const Drive& drive) { on_call_.require_possible(drive, on_call_.limits()); });
    run::RunOptions run = run_;
    run.drive = way.drive;
    begin_run(run, way.task, {}, way.walk, channels, [this, way](const std::string& /*fits*/) {
        to_middle_.begin(way);
        log("note",
            fmt::format("the walker is brought to the middle at gamma {:.3g} g, phi {:.0f} deg; {}",
                        way.drive.gamma / paper_g, way.drive.phi * 180 / std::numbers::pi, text(way.walk)));
    });
}

// A walker that has left the pictures can be put back, too.
template <>
void BenchService::obey(const PutWalkerBack& /*order*/, acquisition::Channels& channels) {
    if (!bench_.world) throw InputError{"the walker is real: put it back by hand"};
    const run::RunState state = on_call_.state();
    if (state == run::RunState::tripped || channels.stopped)
        throw InputError{"the walker cannot be put back while the bench is tripped; clear the trip first"};
    if (state != run::RunState::idle)
        throw InputError{fmt::format(
            "the walker cannot be put back while the bench is {}; wait until it is idle, or stop the drive",
            row_of(state).shown)};
    bench_.world->put_walker_back();
    log("note", "the simulated walker is put back to the middle of its base");
}

template <>
void BenchService::obey(const MeasurePlan& order, acquisition::Channels& channels) {
    on_call_.require_idle("a campaign", channels);
    require_name("plan", order.name);
    const auto state = bench_port_.state();
    campaign_.prepare(order.name, order.text, run_, state && state->walker ? view_m(*state->walker) : NAN);
    rest_ = [this](acquisition::Channels& now) {
        return campaign_.begin([&] { on_call_.require_idle("a campaign", now); });
    };
}

template <>
void BenchService::obey(const CheckPlan& order, acquisition::Channels& /*channels*/) {
    require_name("plan", order.name);
    const auto state = bench_port_.state();
    if (!state || !state->walker || std::isnan(view_m(*state->walker)))
        throw InputError{"a plan cannot be checked before the cameras have shown the walker"};
    const WalkerState& walker = *state->walker;
    campaign_.check(
        order.name, order.text,
        {.view_m = view_m(walker),
         .place_m = walker.x_m - 0.5 * (walker.left_m + walker.right_m),
         .bytes_per_s = state->outlook.sizes.at(static_cast<std::size_t>(run_.pictures)).bytes_per_s});
    rest_ = [this](acquisition::Channels& /*channels*/) { return campaign_.read(); };
}

template <>
void BenchService::obey(const TellCampaign& order, acquisition::Channels& /*channels*/) {
    campaign_.obey(order.word);
}

template <>
void BenchService::obey(const End& /*order*/, acquisition::Channels& channels) {
    const auto drives = std::stable_partition(
        held_.begin(), held_.end(), [](const Order& held) { return !row_of(held.what).when.starts; });
    const bool voids = drives != held_.end();
    std::move(drives, held_.end(), std::back_inserter(voided_));
    held_.erase(drives, held_.end());
    if (campaign_.active()) return campaign_.obey(campaign::Word::pause);
    if (voids && on_call_.state() == run::RunState::idle && !campaign_.prepares()) return;
    if (campaign_.prepares()) return campaign_.cancel();
    on_call_.end(channels);
}

template <>
void BenchService::obey(const ClearTrip& order, acquisition::Channels& channels) {
    on_call_.clear(order.shown, aborts_seen_, channels);
}

template <>
void BenchService::obey(const Record& order, acquisition::Channels& /*channels*/) {
    if (to_middle_.active())
        throw InputError{
            "the walker is being brought to the middle, which is not recorded; wait until the bench is idle"};
    const std::string stem =
        order.name.ends_with(".nxs") ? order.name.substr(0, order.name.size() - 4) : order.name;
    if (!stem.empty()) require_name("recording", stem);
    if (order.on && driving(sequence_.state()) && record_.on())
        throw InputError{
            fmt::format("the run is being recorded in {}; end that recording first", record_.name())};
    if (!recordable(order.pictures, opened_))
        throw InputError{fmt::format("pictures \"{}\": the cameras are open for \"{}\"; {} allowed",
                                     name(order.pictures), name(opened_), allowed_pictures(opened_))};
    if (!order.on || stem.empty()) return record(order, stem);
    auto is_new = std::make_shared<std::future<void>>(
        disk_.run([file = record_.file_named(stem)] { recording::require_new(file); }));
    rest_ = [this, order, stem, is_new](acquisition::Channels& /*channels*/) {
        if (!is_ready(*is_new)) return false;
        is_new->get();
        record(order, stem);
        return true;
    };
}

void BenchService::record(const Record& order, const std::string& stem) {
    const bool driven = driving(sequence_.state());
    run::RunOptions run = run_;
    run.pictures = order.pictures;
    if (driven && order.on) on_call_.record(run, record_.file_named(stem));
    if (driven && !order.on) on_call_.end_recording();
    recorded_ = order.on;
    name_ = order.on ? stem : std::string{};
    run_.pictures = order.pictures;
}

template <>
void BenchService::obey(const Remark& order, acquisition::Channels& /*channels*/) {
    require_remark(order.text);
    record_.remark(order.text, sequence_);
    log("remark", order.text);
}

template <>
void BenchService::obey(const CloseLoop& order, acquisition::Channels& /*channels*/) {
    sequence_.close_loop(order.on);
    run_.closed_loop = order.on;
}

template <>
void BenchService::obey(const LowerLimit& order, acquisition::Channels& channels) {
    safety::Limits limits = on_call_.limits();
    safety::lower(limits, order.key, order.value);
    take_limits(limits, channels);
}

template <>
void BenchService::obey(const GiveMu& order, acquisition::Channels& /*channels*/) {
    require_allowed("mu", order.mu.value, allowed_friction);
    require_allowed("error of mu", order.mu.sigma, {0, order.mu.value});
    if (const law::Fit& fit = live_mu_.mu(); std::isfinite(fit.value) && !fit.refused)
        throw InputError{fmt::format("mu {:.4g}: the measurements give mu {:.4g} +- {:.2g}, which is used",
                                     order.mu.value, fit.value, fit.error)};
    mu_ = order.mu;
    mu_given_ = true;
    compare_points();
    log("note", fmt::format("mu is {:.4g} by the operator", mu_.value));
}

template <>
void BenchService::obey(const MoveTargets& order, acquisition::Channels& /*channels*/) {
    if (const run::RunState state = on_call_.state();
        state != run::RunState::idle && state != run::RunState::tripped)
        throw InputError{fmt::format(
            "the targets cannot be moved while the bench is {}; wait until it is idle, or stop the drive",
            row_of(state).shown)};
    collector_.move_targets(order.targets);
    BenchFacts facts = *facts_;
    facts.views = collector_.views();
    facts_ = std::make_shared<const BenchFacts>(std::move(facts));
}

template <>
void BenchService::obey(const Adopt& order, acquisition::Channels& channels) {
    const run::RunState state = on_call_.state();
    if (driving(state) || state == run::RunState::armed)
        throw InputError{fmt::format("the settings cannot change while the bench is {}; stop the drive first",
                                     row_of(state).shown)};
    const safety::Limits limits =
        order.restores_limits ? order.limits : with_changes(on_call_.limits(), filed_limits_, order.limits);
    on_call_.require_possible(order.drive, limits);
    run_.drive = order.drive;
    run_.plan = order.plan;
    predict();
    armed_ = false;
    filed_limits_ = order.limits;
    take_limits(limits, channels);
}

void BenchService::take_limits(const safety::Limits& limits, acquisition::Channels& channels) {
    on_call_.hold_to(limits, channels);
    predicted_ = run::run_demands(bench_, run_.drive, on_call_.limits());
}

// A flood of orders must not keep the control from its data.
void BenchService::answer(acquisition::Channels& channels) {
    Answers answers;
    go_on(answers, channels);
    while (answers.size() < most_orders) {
        auto order = next_order();
        if (!order) break;
        std::string refused;
        try {
            aborts_seen_ = channels.aborts;
            require_possible(*order);
            std::visit([&](const auto& what) { obey(what, channels); }, order->what);
        } catch (const std::exception& e) {
            rest_ = {};
            refused = e.what();
        }
        if (rest_) {
            waiting_.emplace_back(std::move(*order), std::exchange(rest_, {}));
            go_on(answers, channels);  // in lockstep it is carried out now
        } else {
            answers.emplace_back(std::move(*order), std::move(refused));
        }
        for (Order& voided : voided_)
            answers.emplace_back(std::move(voided), "a stop came after this order, before its drive began");
        voided_.clear();
    }
    if (answers.empty()) return;
    answered_ += answers.size();
    publish();
    for (const auto& [order, refused] : answers)
        if (order.answer) order.answer(refused);
}

}  // namespace shaker::service

// The bench's orders: checks, refusals and execution.
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <exception>

#include "daemon/recording/recorder.hpp"
#include "daemon/run/run_setup.hpp"
#include "daemon/service/bench_service.hpp"
#include "daemon/service/order_texts.hpp"
#include "daemon/service/state_builder.hpp"
#include "drivers/errors.hpp"

namespace shaker::service {

namespace {

constexpr int longest_measurement_s = 100;
constexpr std::size_t most_orders = 16;  // in a step

void require(const char* what, double value, Range range, const std::string& unit) {
    if (value >= range.min && value <= range.max) return;
    throw InputError{
        fmt::format("{} {}{}: {}{} is allowed", what, to_text(value), unit, to_text(range), unit)};
}

}  // namespace

// A program that ends starts, changes and clears nothing.
void BenchService::require_staying(const Order& order) const {
    const bool drives =
        std::holds_alternative<SetDrive>(order.what) || std::holds_alternative<Begin>(order.what) ||
        std::holds_alternative<Identify>(order.what) || std::holds_alternative<ClearTrip>(order.what);
    if (leaving_ && drives) throw InputError{"the program is ending; give the order after its next start"};
}

// An abort voids the orders that were waiting. Those that cannot lead to a drive are carried out.
void BenchService::require_newer_than_abort(const Order& order) const {
    if (order.aborts == bench_port_.aborted() || std::holds_alternative<Remark>(order.what) ||
        std::holds_alternative<LowerLimit>(order.what) || std::holds_alternative<End>(order.what))
        return;
    throw InputError{"an abort came after this order; give it again if it is still wanted"};
}

// A flood of orders must not keep the control from its data.
void BenchService::answer(acquisition::Channels& channels) {
    std::vector<std::pair<Order, std::string>> answers;
    while (answers.size() < most_orders) {
        auto order = bench_port_.next();
        if (!order) break;
        std::string refused;
        try {
            aborts_seen_ = channels.aborts;
            require_newer_than_abort(*order);
            require_staying(*order);
            std::visit([&](const auto& what) { obey(what, channels); }, order->what);
        } catch (const std::exception& e) {
            refused = e.what();
        }
        answers.emplace_back(std::move(*order), std::move(refused));
    }
    if (answers.empty()) return;
    answered_ += answers.size();
    publish();
    for (const auto& [order, refused] : answers)
        if (order.answer) order.answer(refused);
}

void BenchService::require_possible(const Drive& drive, const safety::Limits& limits) const {
    require("frequency", drive.frequency, drive_limits.frequency, " Hz");
    require("gamma", drive.gamma, drive_limits.gamma, " m/s^2");
    require("rho", drive.rho, drive_limits.rho, "");
    require("phi", drive.phi, drive_limits.phi, " rad");
    for (const std::complex<double>& share : drive.overtones)
        require("share of an overtone", std::abs(share), drive_limits.share, " of gamma");
    safety::require_within(run::run_demands(bench_, drive, limits));
}

void BenchService::obey(const SetDrive& order, acquisition::Channels& channels) {
    require_possible(order.drive, limits_);
    const run::RunState state = sequence_.state();
    if (state == run::RunState::run) {
        if (record_.on() && order.drive.frequency != run_.drive.frequency)
            throw InputError{"the frequency cannot change during a recorded run; stop the run first"};
        sequence_.set(order.drive, channels);
    } else if (driving(state)) {
        throw InputError{fmt::format(
            "the drive cannot be changed in state {}; wait until it runs, or stop it", name(state))};
    }
    run_.drive = order.drive;
    predicted_ = run::run_demands(bench_, run_.drive, limits_);
    armed_ = !driving(state);
}

void BenchService::obey(const Begin& order, acquisition::Channels& channels) {
    const int most = static_cast<int>(longest_measurement_s * run_.drive.frequency);
    require("periods", order.periods, {2, static_cast<double>(most)}, "");
    require("settle_periods", order.settle, {0, most_settle_periods}, "");
    require_possible(run_.drive, limits_);
    runner_.require_commissioned();
    runner_.require_real_time();
    sequence_.require_idle("a run", channels);
    const auto walk = run::predict_walk(run_.drive, points_, mu_, bench_.gravity);
    const auto permit = walk_from_the_edge(walk);
    run_.periods = order.periods;
    run_.settle = order.settle;
    record_.begin(run_, recorded_ ? record_.file_named(name_) : std::filesystem::path{}, sequence_.now_s());
    warned_.clear();
    name_.clear();
    active_ = true;
    measured_ = logged_notes_ = 0;
    result_.reset();
    not_reduced_.clear();
    if (walk) {
        const std::string fits = what_fits(*walk, sequence_.walker(), limits_.edge_mm, run_.drive.frequency);
        if (!fits.empty()) log("note", fits);
    }
    // Throws after an abort in this moment; its trip then ends the recording.
    sequence_.begin(run_.drive, order.periods, order.settle, channels, permit);
}

// A walker beyond the edge limit, or so near to it that its oscillation would cross it, may start if it will
// certainly walk inwards.
std::optional<safety::EdgePermit> BenchService::walk_from_the_edge(
    const std::optional<run::PredictedWalk>& walk) const {
    const run::WalkerMonitor& walker = sequence_.walker();
    const auto edge_mm = walker.mean_edge_mm();
    const auto travel = std::ranges::find(predicted_, "displacement", &safety::Demand::quantity);
    const double inside_mm = limits_.edge_mm + travel->value;
    if (!edge_mm || *edge_mm >= inside_mm) return std::nullopt;
    const double outer_mm = safety::EdgePermit::outer_limit_mm(sequence_.edge_trip_mm().value_or(*edge_mm));
    const bool inwards = walk && leads_towards(*walk, walker.inwards());
    if (inwards && *edge_mm >= outer_mm) return safety::EdgePermit{*edge_mm, inside_mm, outer_mm};
    if (*edge_mm >= limits_.edge_mm) return std::nullopt;
    std::string reason = "move it back by hand";
    if (!walk)
        reason = "its walk is not known: give mu in the settings, or " + reason;
    else if (!inwards)
        reason = fmt::format("{} does not lead inwards by three times its error; try phi + 180 deg, or {}",
                             text(*walk), reason);
    throw InputError{fmt::format("the walker is {:.1f} mm from the edge of the picture (at least {} mm); {}",
                                 *edge_mm, limits_.edge_mm, reason)};
}

void BenchService::obey(const Identify& /*order*/, acquisition::Channels& channels) {
    require_possible(run_.drive, limits_);
    runner_.require_commissioned();
    runner_.require_real_time();
    sequence_.require_idle("identification", channels);
    record_.begin(run_, {}, sequence_.now_s());
    warned_.clear();
    sequence_.identify(run_.drive, channels);
    logged_notes_ = 0;
    active_ = true;
}

void BenchService::obey(const End& /*order*/, acquisition::Channels& channels) { sequence_.end(channels); }

void BenchService::obey(const ClearTrip& order, acquisition::Channels& channels) {
    if (order.shown != sequence_.stops().size() && sequence_.state() == run::RunState::tripped)
        throw InputError{"a trip came after this clear; look at its cause, then clear it"};
    if (record_.finishing())
        throw InputError{
            "the recording of the stopped run is still being finished; wait, then clear the trip"};
    sequence_.clear(aborts_seen_, channels);
}

void BenchService::obey(const Record& order, acquisition::Channels& /*channels*/) {
    if (driving(sequence_.state()))
        throw InputError{fmt::format("recording cannot be switched in state {}; stop the drive first",
                                     name(sequence_.state()))};
    const std::string stem =
        order.name.ends_with(".nxs") ? order.name.substr(0, order.name.size() - 4) : order.name;
    if (!stem.empty()) require_name(stem);
    if (order.on && !stem.empty()) recording::require_new(record_.file_named(stem));
    if (order.pictures != recorded::KeptPictures::off && order.pictures != opened_)
        throw InputError{
            fmt::format("pictures \"{}\": the cameras are open for \"{}\"; only that or \"off\" is allowed",
                        name(order.pictures), name(opened_))};
    recorded_ = order.on;
    name_ = order.on ? stem : std::string{};
    run_.pictures = order.pictures;
}

void BenchService::obey(const Remark& order, acquisition::Channels& /*channels*/) {
    require_remark(order.text);
    record_.remark(order.text, sequence_);
    log("remark", order.text);
}

void BenchService::obey(const CloseLoop& order, acquisition::Channels& /*channels*/) {
    sequence_.close_loop(order.on);
    run_.closed_loop = order.on;
}

void BenchService::obey(const LowerLimit& order, acquisition::Channels& channels) {
    safety::Limits limits = limits_;
    safety::lower(limits, order.key, order.value);
    take_limits(limits, channels);
}

void BenchService::obey(const Adopt& order, acquisition::Channels& channels) {
    const run::RunState state = sequence_.state();
    if (driving(state))
        throw InputError{
            fmt::format("the settings cannot change in state {}; stop the drive first", name(state))};
    const safety::Limits limits =
        order.restores_limits ? order.limits : with_changes(limits_, filed_limits_, order.limits);
    require_possible(order.drive, limits);
    run_.drive = order.drive;
    run_.periods = order.periods;
    run_.settle = order.settle;
    armed_ = false;
    filed_limits_ = order.limits;
    take_limits(limits, channels);
}

void BenchService::take_limits(const safety::Limits& limits, acquisition::Channels& channels) {
    const auto detectors = limits_.detectors;
    limits_ = limits;
    limits_.detectors = detectors;
    predicted_ = run::run_demands(bench_, run_.drive, limits_);
    sequence_.hold_to(limits_, channels);
}

}  // namespace shaker::service

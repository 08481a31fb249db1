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

void require(const char* what, double value, Range range, const std::string& unit) {
    if (value >= range.min && value <= range.max) return;
    throw InputError{
        fmt::format("{} {}{}: {}{} is allowed", what, to_text(value), unit, to_text(range), unit)};
}

void require_lower(const char* what, double now, double wanted) {
    if (wanted <= now) return;
    throw InputError{
        fmt::format("limit {} {}: at most the present {} is allowed; only the settings file can raise limits",
                    what, to_text(wanted), to_text(now))};
}

void require_inside(double edge_mm, const safety::Limits& limits, const std::string& way_back) {
    if (edge_mm >= limits.edge_mm) return;
    throw InputError{fmt::format("the walker is {:.1f} mm from the edge of the picture (at least {} mm); {}",
                                 edge_mm, limits.edge_mm, way_back)};
}

}  // namespace

// An abort voids the orders that were waiting. Those that cannot lead to a drive are carried out.
void BenchService::require_newer_than_abort(const Order& order) const {
    if (order.aborts == bench_port_.aborted() || std::holds_alternative<Remark>(order.what) ||
        std::holds_alternative<LowerLimits>(order.what) || std::holds_alternative<End>(order.what))
        return;
    throw InputError{"an abort came after this order; give it again if it is still wanted"};
}

bool BenchService::answer(acquisition::Channels& channels) {
    bool any = false;
    while (const auto order = bench_port_.next()) {
        any = true;
        std::string refused;
        try {
            aborts_seen_ = channels.aborts;
            require_newer_than_abort(*order);
            std::visit([&](const auto& what) { obey(what, channels); }, order->what);
        } catch (const std::exception& e) {
            refused = e.what();
        }
        ++answered_;
        publish();
        if (order->answer) order->answer(refused);
    }
    return any;
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
    stop_recorded_ = false;
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
    std::string reason = "move it back by hand";
    if (!walk)
        reason = "its walk is not known: give mu in the settings, or " + reason;
    else if (!inwards)
        reason = fmt::format("{} does not lead inwards by three times its error; try phi + 180 deg, or {}",
                             text(*walk), reason);
    require_inside(*edge_mm, limits_, reason);
    return std::nullopt;
}

void BenchService::obey(const Identify& /*order*/, acquisition::Channels& channels) {
    require_possible(run_.drive, limits_);
    runner_.require_commissioned();
    runner_.require_real_time();
    sequence_.require_idle("identification", channels);
    if (const auto edge_mm = sequence_.walker().mean_edge_mm())
        require_inside(*edge_mm, limits_, "move it back by hand");
    record_.begin(run_, {}, sequence_.now_s());
    warned_.clear();
    sequence_.identify(run_.drive, channels);
    logged_notes_ = 0;
    active_ = true;
    stop_recorded_ = false;
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

void BenchService::obey(const LowerLimits& order, acquisition::Channels& channels) {
    const safety::Limits &now = limits_, &wanted = order.limits;
    const auto level = [](const char* what, const safety::Level& a, const safety::Level& b) {
        require_lower(what, a.warn, b.warn);
        require_lower(what, a.abort, b.abort);
    };
    level("acceleration", now.acceleration, wanted.acceleration);
    level("rms acceleration", now.acceleration_rms, wanted.acceleration_rms);
    level("coil", now.coil_A, wanted.coil_A);
    level("velocity", now.velocity, wanted.velocity);
    level("displacement", now.displacement, wanted.displacement);
    level("drive", now.drive, wanted.drive);
    level("transverse", now.transverse, wanted.transverse);
    require_lower("edge", -now.edge_mm, -wanted.edge_mm);
    take_limits(wanted, channels);
}

void BenchService::obey(const Adopt& order, acquisition::Channels& channels) {
    const run::RunState state = sequence_.state();
    if (driving(state))
        throw InputError{
            fmt::format("the settings cannot change in state {}; stop the drive first", name(state))};
    require_possible(order.drive, order.limits);
    run_.drive = order.drive;
    run_.periods = order.periods;
    run_.settle = order.settle;
    armed_ = false;
    take_limits(order.limits, channels);
}

void BenchService::take_limits(const safety::Limits& limits, acquisition::Channels& channels) {
    const auto detectors = limits_.detectors;
    limits_ = limits;
    limits_.detectors = detectors;
    predicted_ = run::run_demands(bench_, run_.drive, limits_);
    sequence_.hold_to(limits_, channels);
}

}  // namespace shaker::service

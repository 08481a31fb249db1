// The conditions under which each state of a run ends, and the state that follows.
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "daemon/reduction/check/bench_check.hpp"
#include "daemon/run/sequence.hpp"

namespace shaker::run {

namespace {

// Whether a run in `from` may go to `to`. Any state may trip. From there idle follows, or init while the
// self-test has not been passed.
bool may_follow(RunState from, RunState to) noexcept {
    using enum RunState;
    // A loop check starts again when the DAC runs empty again.
    constexpr std::array ways{
        std::pair{init, self_test},   std::pair{self_test, idle},     std::pair{idle, armed},
        std::pair{armed, idle},       std::pair{armed, identify},     std::pair{armed, ramp},
        std::pair{identify, ramp},    std::pair{identify, ramp_down}, std::pair{ramp, run},
        std::pair{ramp, ramp_down},   std::pair{run, ramp},           std::pair{run, ramp_down},
        std::pair{armed, loop_check}, std::pair{loop_check, ramp},    std::pair{loop_check, ramp_down},
        std::pair{ramp, loop_check},  std::pair{run, loop_check},     std::pair{loop_check, loop_check},
        std::pair{ramp_down, idle},   std::pair{tripped, idle},       std::pair{tripped, init}};
    return (to == tripped && from != tripped) || std::ranges::find(ways, std::pair{from, to}) != ways.end();
}

constexpr double accelerometer_patience_s = 8;  // longer than the time-out of its driver
constexpr double camera_patience_s = 2;
constexpr int check_ramp = 2;         // periods to the level of the loop check
constexpr double check_periods = 60;  // longest loop check: this and check_patience_s
constexpr double check_patience_s = 2;
constexpr double matters = 5e-4;  // of gamma: less of the mains does not move a locked drive
constexpr double faint_drive_mps2 = 2.5;
constexpr int least_held = 2;  // windows of a held drive: the walker follows its last change
}  // namespace

void Sequence::go(const State& next, acquisition::Channels& channels) {
    if (!may_follow(state(), named(next))) {
        note(fmt::format("internal error: a run cannot go from state {} to {}", name(state()),
                         name(named(next))));
        stop(channels, {.cause = safety::Cause::watchdog});
        return;
    }
    state_ = next;
    since_s_ = now_s_;
}

bool Sequence::done() const noexcept {
    const auto* idle = std::get_if<Idle>(&state_);
    const bool silent = !driving(state()) && state() != RunState::tripped;
    return may_clear() || (idle != nullptr && idle->ended) || (leaving_ && silent);
}

bool Sequence::may_clear() const noexcept {
    const auto* tripped = std::get_if<Tripped>(&state_);
    return tripped != nullptr && tripped->phase == Tripped::Phase::silent;
}

void Sequence::advance(Init& init, acquisition::Channels& channels) {
    if (!clocks_known_) return;
    controller_.forget_noise();
    go(Quiet{.from_s = init.from_s}, channels);
}

void Sequence::advance(Quiet& quiet, acquisition::Channels& channels) {
    if (now_s_ < since_s_ + plan_.quiet_s) return;
    if (!quiet.judged && guard_.settles() && !std::exchange(quiet.waits, true))
        say_("self-test: waits until the constant part of the accelerometer has settled");
    if (!quiet.judged || awaits_view(channels)) return;
    if (!std::exchange(quiet.mains_sought, true) && fit_mains()) {  // the noise is measured without it
        quiet.from_s = since_s_ = now_s_;
        quiet.judged = false;
        return controller_.forget_noise();
    }
    self_tested_ = true;
    go(Idle{}, channels);
    if (plan_.on_call) return;
    if (plan_.walk)
        if (const std::string fits =
                what_fits(*plan_.walk, walker_, plan_.limits.edge_mm, controller_.drive());
            !fits.empty())
            note(fits);
    arm(channels);
}

// True when the mains are found in the sensor and their strongest line is fitted from now on. What the
// settings say goes before. On call, the set-points are not known yet.
bool Sequence::fit_mains() {
    const auto mains = windows_.mains();
    const double least = matters * (plan_.on_call ? faint_drive_mps2 : controller_.drive().gamma);
    if (plan_.line_hz > 0 || !mains || mains->amplitude_of(mains->strongest()) < least) return false;
    plan_.line_hz = mains->strongest() * mains->hz;
    std::vector<double> lines_hz;
    std::string lines;
    for (int m = 1; m <= control::Mains::multiples; ++m) {
        if (mains->amplitude_of(m) < least) continue;
        lines_hz.push_back(m * mains->hz);
        lines += fmt::format("{}{:.3g} m/s^2 at {:.5g} Hz", lines.empty() ? "" : ", ", mains->amplitude_of(m),
                             lines_hz.back());
    }
    mains_ = fmt::format(
        "mains: the accelerometer shows {} before any drive: a ground loop, or a cable beside a "
        "transformer; the line at {:.5g} Hz is fitted beside the harmonics (mains_hz of [run])",
        lines, plan_.line_hz);
    windows_.fit_line(plan_.line_hz);
    controller_.hide(std::move(lines_hz));
    return true;
}

// Each is noted once.
void Sequence::note_mains() {
    const auto once = [&](const std::string& what) {
        if (!what.empty() && std::ranges::find(notes_, what) == notes_.end()) note(what);
    };
    once(mains_);
    for (const int q : controller_.hidden(frequency_))
        once(fmt::format(
            "mains: harmonic {} of {:.4g} Hz lies on a line of the mains{}", q, frequency_,
            harmonics(controller_.drive()).at(q) != 0.0
                ? ", and the set-point asks for it: choose another frequency"
                : "; the loop does not correct it, and its value in the results contains the mains"));
}

std::string Sequence::mains_doubt(const Drive& drive) const {
    for (const int q : controller_.hidden(drive.frequency))
        if (harmonics(drive).at(q) != 0.0)
            return fmt::format("{}: harmonic {} of {:.4g} Hz lies on a line of the mains",
                               reduction::degraded_note, q, drive.frequency);
    return {};
}

// Not on call, the drive follows. Cameras may start after the DAC.
bool Sequence::awaits_view(acquisition::Channels& channels) {
    if (plan_.on_call || !walker_.has_target() || walker_.sees()) return false;
    if (now_s_ < since_s_ + plan_.quiet_s + camera_patience_s) return true;
    if (!guard_.check_view(walker_, now_s_, channels)) return true;
    return guard_.stop({.cause = safety::Cause::tracking_lost,
                        .value = static_cast<double>(walker_.lost()),
                        .limit = static_cast<double>(plan_.limits.tracking_lost_frames)},
                       now_s_, channels);
}

// A drive from rest begins with this check. resumes: after the DAC ran empty.
void Sequence::check_loop(bool resumes, acquisition::Channels& channels) {
    const control::DriveController& c = controller_;
    const auto& axis = windows_.accelerometer().shaker_axis;
    const bool axis_known = std::ranges::any_of(axis, [](double u) { return u != 0; });
    const safety::LoopCheck loop{{.target = harmonics(c.drive()),
                                  .response = c.response_at(c.drive().frequency),
                                  .identified = c.identified() ? &*c.identified() : nullptr,
                                  .noise = c.noise(),
                                  .direction_known = axis_known || c.identified(),
                                  .gain_shown = plan_.gain_shown}};
    go(LoopCheck{.loop = loop, .resumes = resumes}, channels);
    say_("loop check: ten periods at a low level");
    guard_.loop_check(true, channels);
    command(loop.volts(), check_ramp, true, channels);
}

void Sequence::take_check(LoopCheck& check, const control::PeriodWindows::Window& window,
                          acquisition::Channels& channels) {
    const bool settled =
        window.motion.steady && window.sequence >= drive_.newest() && window.from_s >= drive_.steady_from_s();
    if (check.over || !settled || !check.loop.take(window.estimate.along, window.estimate.periods)) return;
    check.over = true;
    const auto trip = check.loop.trip();
    if (trip && guard_.stop(*trip, now_s_, channels)) return note(check.loop.finding());
    say_(check.loop.finding());
    guard_.loop_check(false, channels);
    if (!check.resumes) return start(channels);
    go(Ramp{}, channels);
    go_for_target(plan_.soft_start, channels);
}

// The check begins with its first sample: the amplifier may have a lead to switch on.
void Sequence::advance(LoopCheck& check, acquisition::Channels& channels) {
    const double from_s =
        std::isfinite(drive_.in_force_s()) ? drive_.in_force_s() : since_s_ + plan_.enable_before_s;
    const double silent_s = now_s_ - from_s, patience_s = check_patience_s + check_periods / frequency_;
    if (check.over || silent_s < patience_s) return;
    check.over = true;
    note("loop check: no complete windows of the accelerometer");
    stop(channels, {.cause = safety::Cause::sensor_missing, .value = silent_s, .limit = patience_s});
}

void Sequence::advance(Ramp& /*ramp*/, acquisition::Channels& channels) {
    if (now_s_ < drive_.in_force_s()) return;
    go(run_state(drive_.in_force_s()), channels);
    say_("settling: waiting until the drive and then the walker's drift are steady");
}

Run Sequence::run_state(double from_s) const {
    const MeasurementPlan& plan = plan_.task.plan;
    return {.from_s = from_s,
            .left = plan.periods == 0 ? 0 : (plan.measurements == 0 ? -1 : plan.measurements)};
}

bool Sequence::holding() const noexcept {
    const auto* run = std::get_if<Run>(&state_);
    return run != nullptr && run->left == 0;
}

int Sequence::left() const noexcept {
    const auto* run = std::get_if<Run>(&state_);
    return run != nullptr ? run->left : 0;
}

std::string Sequence::waits_for() const {
    const auto* run = std::get_if<Run>(&state_);
    if (run == nullptr || run->measuring || run->left == 0) return {};
    const control::Equaliser::Report& report = controller_.report();
    if (plan_.controller.equalise && !report.locked)
        return fmt::format("the base is not within {:.1g} % of its target yet (newest period: {:.2g} % off)",
                           100 * control::kept_within, 100 * report.error);
    if (plan_.controller.equalise && report.held < least_held) return "the drive has just been corrected";
    if (plan_.task.plan.settle > 0)
        return fmt::format("{} periods of the settled drive come first", plan_.task.plan.settle);
    return "the walker's drift still changes from period to period";
}

bool Sequence::measuring() const noexcept {
    const auto* run = std::get_if<Run>(&state_);
    return run != nullptr && run->measuring;
}

void Sequence::advance(Run& run, acquisition::Channels& channels) {
    if (run.left == 0) return;
    if (!run.measuring) return settle(run);
    if (now_s_ < part_.to_s + margin_periods / frequency_ || stragglers_may_come()) return;
    finish_measuring(run);
    if (!plan_.on_call) come_down(channels);
}

void Sequence::finish_measuring(Run& run) {
    measured_.push_back({static_cast<int>(measured_.size()) + 1, controller_.drive(), part_, {}});
    run.measuring = false;
    if (run.left > 0) --run.left;
}

// Only periods whose data have arrived, with the margin that a reduction reads.
void Sequence::keep_whole_periods() {
    auto* run = std::get_if<Run>(&state_);
    if (run == nullptr || !run->measuring) return;
    run->measuring = false;
    double until_s = std::min(now_s_ - margin_periods / frequency_, windows_.until_s());
    if (walker_.watches()) until_s = std::min(until_s, walker_.until_s());
    const double periods = std::floor((until_s - part_.from_s) * frequency_);
    if (periods < least_kept_periods) return;
    part_.to_s = std::min(part_.to_s, part_.from_s + periods / frequency_);
    finish_measuring(*run);
}

void Sequence::settle(Run& run) {
    const bool late = now_s_ - run.from_s > plan_.settle_at_most / frequency_;
    controller_.hold();
    const bool kept = !plan_.controller.equalise ||
                      (controller_.report().locked && controller_.report().held >= least_held);
    if (!kept) run.kept_from_s = now_s_;
    const double steady_from_s = drive_.steady_from_s();
    const bool steady = plan_.task.plan.settle > 0 ? now_s_ > std::max(steady_from_s, run.kept_from_s) +
                                                                  plan_.task.plan.settle / frequency_
                                                   : now_s_ > steady_from_s && walker_settled();
    if ((kept && steady) || late) begin_measuring(!(kept && steady));
}

void Sequence::advance(RampDown& /*down*/, acquisition::Channels& channels) {
    if (now_s_ > drive_.in_force_s()) go(Idle{.ended = !plan_.on_call}, channels);
}

void Sequence::advance(Tripped& tripped, acquisition::Channels& channels) {
    if (now_s_ < tripped.at_s + aftermath_s) return;  // data from before the trip are still arriving
    switch (tripped.phase) {
        case Tripped::Phase::latched:
            tripped.phase = Tripped::Phase::silent;
            break;
        case Tripped::Phase::clearing:
            finish_clearing(channels);
            break;
        case Tripped::Phase::silent:
            break;
    }
}

// A run may be armed in idle, so idle waits until the output has released its stop.
void Sequence::finish_clearing(acquisition::Channels& channels) {
    if (channels.stopped) return;
    guard_.rearm();
    trip_.reset();
    if (self_tested_)
        go(Idle{}, channels);
    else
        go(Init{.from_s = now_s_}, channels);
}

bool Sequence::walker_settled() const {
    return !walker_.watches() || walker_.settled_since(drive_.steady_from_s(), controller_.drive().gamma);
}

void Sequence::come_down(acquisition::Channels& channels) {
    go(RampDown{}, channels);
    say_("soft stop");
    channels.drive.post({.volts = {}, .sequence = drive_.next(), .stop_s = soft_stop_s(plan_, frequency_)});
    drive_.await();
}

void Sequence::begin_measuring(bool late) {
    Run& run = std::get<Run>(state_);
    // When nothing has changed since the previous measurement, this one follows without a gap.
    const bool follows =
        !measured_.empty() && part_.to_s == measured_.back().part.to_s && part_.to_s > drive_.steady_from_s();
    run.measuring = true;
    part_.from_s = follows ? part_.to_s : std::ceil(now_s_ * frequency_) / frequency_;
    part_.to_s = part_.from_s + plan_.task.plan.periods / frequency_;
    if (follows) return;
    say_(fmt::format("measuring {} periods from {:.3f} s on", plan_.task.plan.periods, part_.from_s));
    if (!std::exchange(order_.settling_noted, true)) note_on_settling(late);
}

void Sequence::note_on_settling(bool late) {
    const control::Equaliser::Report& report = controller_.report();
    if (late)
        note(fmt::format("{} had not settled after {} periods; the measurement started anyway",
                         report.locked ? "the walker" : "the drive", plan_.settle_at_most));
    if (report.reached < 1)
        note(report.unreachable
                 ? fmt::format("the bench reaches only {:.1f} % of the requested gamma in this shape",
                               100 * report.reached)
                 : fmt::format("the voltage limit of {} V reaches only {:.1f} % of the requested gamma",
                               plan_.controller.volts_limit, 100 * report.reached));
    if (report.noise_limited)
        note(fmt::format(
            "the sensor's noise is too large to verify each harmonic to 0.1 %: {:.2g} of gamma in a period",
            report.noise));
}

// True while the measurement's last data may still arrive: sensor data arrive late, by seconds when a
// connection is in trouble. Data that are still missing after the waiting time give a note.
bool Sequence::stragglers_may_come() {
    const auto missing = [&](double until_s, double patience_s, const char* what) {
        if (until_s > part_.to_s - 2 / frequency_) return false;
        if (now_s_ < part_.to_s + patience_s) return true;
        note(fmt::format("{} end at {:.3f} s, {:.3f} s before the measurement", what, until_s,
                         part_.to_s - until_s));
        return false;
    };
    return missing(windows_.until_s(), accelerometer_patience_s, "the accelerometer's data") ||
           (walker_.watches() && missing(walker_.until_s(), camera_patience_s, "the walker's pictures"));
}

}  // namespace shaker::run

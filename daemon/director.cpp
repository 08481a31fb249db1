#include "daemon/director.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "drivers/errors.hpp"

namespace shaker {

namespace {
constexpr double accelerometer_patience_s = 8;  // its driver gives up before
constexpr double camera_patience_s = 2;
constexpr double transient_periods = 1;  // after a ramp, until the suspension has followed
constexpr double aftermath_s = 0.3;      // recorded after a trip
constexpr int between_levels = 5;        // periods of the ramps while the response is found out

bool contradicts_prediction(Cause cause) {
    return cause == Cause::residual || cause == Cause::sensor_open || cause == Cause::polarity;
}
}  // namespace

Director::Director(const RunPlan& plan, double dac_rate_hz, const AccelerometerInfo& accelerometer, Say say)
    : plan_{plan},
      dac_rate_hz_{dac_rate_hz},
      frequency_{Synthesiser::realised(plan.keeper.drive.frequency, dac_rate_hz)},
      say_{std::move(say)},
      windows_{dac_rate_hz, accelerometer, plan.keeper.drive.frequency, controlled_harmonics, plan.line_hz},
      keeper_{plan.keeper},
      walker_{frequency_},
      guard_{plan.limits, accelerometer, dac_rate_hz} {}

void Director::go(RunState next) {
    if (!may_follow(state_, next))
        throw std::logic_error{fmt::format("a run cannot go from {} to {}", name(state_), name(next))};
    state_ = next;
    since_s_ = now_s_;
}

bool Director::step(const Take& take, Lanes& lanes) {
    const std::size_t before = plays_ + blocks_ + changes_ + stops_.size() + walker_.seen();
    take_trips(take);
    take_stamps(take, lanes);
    take_accelerations(take, lanes);
    walker_.add(take);
    if (state_ == RunState::run) guard_.look(walker_, now_s_, lanes);
    if (driving(state_)) guard_.look(take.cameras, now_s_, lanes);
    advance(lanes);
    return plays_ + blocks_ + changes_ + stops_.size() + walker_.seen() != before;
}

// The first of them is the cause; the output has begun its ramp to zero.
void Director::take_trips(const Take& take) {
    while (stops_.size() < take.trips.size()) {
        const Trip& trip = take.trips[stops_.size()];
        stops_.push_back({state_, measuring_});
        note(fmt::format("stopped in state {}: {}", name(state_), text(trip)));
        if (state_ == RunState::tripped && !std::exchange(clearing_, false)) continue;
        trip_ = trip;
        cause_ = stops_.size() - 1;
        tripped_s_ = now_s_;
        measuring_ = excused_ = released_ = false;
        if (state_ != RunState::tripped) go(RunState::tripped);
        if (now_s_ < lost_s_ + aftermath_s) blame_dac();
    }
}

// A base that stood still, or swung out by itself, because the DAC had run empty may be noticed before the
// DAC is. The drive comes back softly where it may after an underrun; what was not the DAC's doing shows
// again.
void Director::blame_dac() {
    if (!contradicts_prediction(trip_->cause)) return;
    note("the base did not follow because the DAC had run empty");
    trip_ =
        Trip{.cause = Cause::underrun,
             .on_dac_clock = true,
             .value = static_cast<double>(lost_),
             .tick = trip_->on_dac_clock ? trip_->tick : static_cast<std::int64_t>(lost_s_ * dac_rate_hz_)};
    excused_ = !plan_.limits.detectors[static_cast<std::size_t>(Cause::underrun)];
}

void Director::unlatch(Lanes& lanes) {
    if (!released_) {
        ++lanes.releases;
        released_ = true;
        return;
    }
    if (lanes.stopped) return;
    guard_.rearm();
    trip_.reset();
    excused_ = false;
    go(RunState::idle);
    arm(lanes);
}

void Director::take_stamps(const Take& take, Lanes& lanes) {
    for (; plays_ < take.dropped.played + take.played.size(); ++plays_) {
        const PlayTime& played = take.played[plays_ - take.dropped.played];
        windows_.add(played);
        if (played.lost > 0)
            start_again(played.lost, lanes);
        else
            now_s_ = static_cast<double>(played.tick.n) / dac_rate_hz_;
    }
    for (; changes_ < take.dropped.changes + take.changes.size(); ++changes_) {
        const DriveChange& c = take.changes[changes_ - take.dropped.changes];
        windows_.add(c);
        // The silence after lost time has no number: the ramp up from it is still to come.
        if (c.stop > 0 || c.command.sequence < awaited_ || c.command.sequence == 0) continue;
        in_force_s_ = static_cast<double>(c.first.n + c.ramp) / dac_rate_hz_;
        if (c.command.sequence >= target_sequence_) target_from_s_ = std::min(target_from_s_, in_force_s_);
        if (!std::isfinite(steady_from_s_)) steady_from_s_ = in_force_s_ + transient_periods / frequency_;
    }
}

// The DAC ran empty and stands at zero: what was measured so far is cut, the drive comes up softly once more.
void Director::start_again(std::int64_t lost, Lanes& lanes) {
    lost_ = lost;
    lost_s_ = now_s_;
    guard_.clocks_lost();
    if (done_) return;
    note(fmt::format("the DAC ran empty at {:.3f} s and stood still for {:.1f} ms", now_s_,
                     1e3 * static_cast<double>(lost) / dac_rate_hz_));
    if (state_ == RunState::ramp_down) {  // it is silent already
        go(RunState::idle);
        done_ = !plan_.on_call;
        return;
    }
    if ((driving(state_) || !plan_.on_call) && ++restarts_ > plan_.most_restarts) {
        if (!plan_.on_call)
            throw DeviceError{fmt::format("the DAC ran empty {} times in one run; given up", restarts_)};
        stop(lanes, {.cause = Cause::underrun, .value = static_cast<double>(lost)});
    }
    if (state_ == RunState::tripped) {
        blame_dac();
        return;
    }
    measuring_ = false;
    if (state_ == RunState::run) go(RunState::ramp);
    if (driving(state_)) go_for_target(plan_.soft_start, lanes);
}

void Director::take_accelerations(const Take& take, Lanes& lanes) {
    for (; blocks_ < take.dropped.blocks + take.blocks.size(); ++blocks_) {
        const AccelBlock& block = take.blocks[blocks_ - take.dropped.blocks];
        last_tick_ = {block.first.n + block.size - 1};
        for (const MotionWindows::Window& window : windows_.add(block)) {
            newest_ = window;
            window_done(window, lanes);
        }
    }
}

// The one back arrow: what a window showed corrects the drive.
void Director::window_done(const MotionWindows::Window& window, Lanes& lanes) {
    if (state_ == RunState::self_test) {
        keeper_.quiet(window.estimate);
        guard_.look_at_rest(window, lanes);
    }
    if (state_ != RunState::identify && state_ != RunState::run) return;
    // A correction under way is a drive like any other to those that follow every window.
    const bool newest = window.sequence >= sequence_;
    const DriveKeeper::Outcome outcome = keeper_.take(window, newest);
    // A window from before the target was changed is none of this one's, nor of its frequency.
    const bool current = state_ == RunState::identify || window.from_s >= target_from_s_;
    const bool followed = current && state_ == RunState::run && plan_.keeper.equalise;
    guard_.look(window, keeper_, {current, followed}, windows_.clock(), last_tick_, lanes);
    switch (outcome) {
        case DriveKeeper::Outcome::nothing:
            break;
        case DriveKeeper::Outcome::step:
            if (const IdentifiedResponse* found = keeper_.found()) guard_.look(*found, false, now_s_, lanes);
            command(keeper_.volts(), state_ == RunState::identify ? between_levels : 1, true, lanes);
            break;
        case DriveKeeper::Outcome::correction:
            command(keeper_.volts(), 1, false, lanes);
            break;
        case DriveKeeper::Outcome::identified:
            for (const std::string& finding : findings(*keeper_.identified())) note(finding);
            guard_.look(*keeper_.identified(), true, now_s_, lanes);
            if (only_identify_)
                come_down(lanes);
            else
                start(lanes);
            break;
    }
    if (state_ == RunState::run) tell(window);
}

void Director::tell(const MotionWindows::Window& window) {
    if (plan_.on_call) return;  // who wants to know looks at the state
    // What stays the same is told once a second.
    const bool locked = keeper_.report().locked;
    if (window.from_s < told_s_ + (locked ? 1 : 0.25)) return;
    told_s_ = window.from_s;
    const Drive got = drive_of(window.estimate.along, frequency_);
    say_(fmt::format("{:7.3f} s  gamma {:.4f} m/s^2  phi {:+.3f} deg  drive {}", window.from_s, got.gamma,
                     got.phi * 180 / std::numbers::pi,
                     !plan_.keeper.equalise ? "open loop" : (locked ? "locked" : "settling")));
}

void Director::arm(Lanes& lanes) {
    go(RunState::armed);
    if (!keeper_.identified() && keeper_.begin_identification()) {
        go(RunState::identify);
        say_("finding out how the base answers to the drive");
        command(keeper_.volts(), plan_.soft_start, true, lanes);
    } else {
        start(lanes);
    }
}

void Director::start(Lanes& lanes) {
    keeper_.begin();
    go(RunState::ramp);
    say_(fmt::format("soft start over {} periods", plan_.soft_start));
    go_for_target(plan_.soft_start, lanes);
}

// From here to where the keeper wants to go: until that is in force nothing is judged against it.
void Director::go_for_target(int ramp_periods, Lanes& lanes) {
    command(keeper_.volts(), ramp_periods, true, lanes);
    guard_.settling();
    target_sequence_ = sequence_;
    target_from_s_ = INFINITY;
    kept_from_s_ = -INFINITY;
}

void Director::advance(Lanes& lanes) {
    switch (state_) {
        case RunState::init:
            if (windows_.clock().ready()) go(RunState::self_test);
            break;
        case RunState::self_test:
            if (now_s_ < plan_.quiet_s) break;
            go(RunState::idle);
            if (!plan_.on_call) arm(lanes);
            break;
        case RunState::ramp:
            if (now_s_ < in_force_s_) break;
            go(RunState::run);
            run_from_s_ = in_force_s_;
            say_("settling: the drive by its measured harmonics, then the walker");
            break;
        case RunState::run: {
            if (measuring_) {
                if (now_s_ < to_s_ + 2 / frequency_ || stragglers_may_come()) break;
                measured_.push_back({from_s_, to_s_});
                measuring_ = false;
                if (!plan_.on_call) come_down(lanes);
                break;
            }
            const bool late = now_s_ - run_from_s_ > plan_.settle_at_most / frequency_;
            const bool kept = !plan_.keeper.equalise || keeper_.report().locked;
            if (!kept) kept_from_s_ = now_s_;
            const bool steady =
                plan_.settle > 0 ? now_s_ > std::max(steady_from_s_, kept_from_s_) + plan_.settle / frequency_
                                 : now_s_ > steady_from_s_ && walker_settled();
            if ((kept && steady) || late) begin_measuring(!(kept && steady));
            break;
        }
        case RunState::ramp_down:
            if (now_s_ <= in_force_s_) break;
            go(RunState::idle);
            done_ = !plan_.on_call;
            break;
        case RunState::tripped:  // what led to it is still on its way
            if (now_s_ < tripped_s_ + aftermath_s) break;
            if (clearing_)
                finish_clearing(lanes);
            else if (excused_)
                unlatch(lanes);
            else
                done_ = true;
            break;
        case RunState::idle:
        case RunState::armed:
        case RunState::identify:
            break;
    }
}

bool Director::walker_settled() const {
    return !walker_.watches() || walker_.settled_since(steady_from_s_, keeper_.drive().gamma);
}

void Director::come_down(Lanes& lanes) {
    go(RunState::ramp_down);
    say_("soft stop");
    command({}, plan_.soft_start, true, lanes);
}

void Director::begin_measuring(bool late) {
    // Where nothing changed since the measurement before, this one follows it without a gap.
    const bool follows = !measured_.empty() && to_s_ == measured_.back().to_s && to_s_ > steady_from_s_;
    const Equaliser::Report& report = keeper_.report();
    measuring_ = true;
    from_s_ = follows ? to_s_ : std::ceil(now_s_ * frequency_) / frequency_;
    to_s_ = from_s_ + plan_.periods / frequency_;
    if (follows) return;
    say_(fmt::format("measuring {} periods from {:.3f} s on", plan_.periods, from_s_));
    if (std::exchange(told_late_, true)) return;
    if (late)
        note(fmt::format("{} had not settled after {} periods; it was measured all the same",
                         report.locked ? "the walker" : "the drive", plan_.settle_at_most));
    if (report.reached < 1)
        note(report.unreachable
                 ? fmt::format("the bench gives no more than {:.1f} % of the asked gamma in this shape",
                               100 * report.reached)
                 : fmt::format("the DAC's {} V reach only {:.1f} % of the asked gamma",
                               plan_.keeper.volts_limit, 100 * report.reached));
    if (report.noise_limited)
        note(fmt::format(
            "the sensor's noise, {:.2g} of gamma in a period, hides whether each harmonic is within "
            "0.1 %",
            report.noise));
}

// What a sensor measured comes later than it was measured, by seconds when its connection is in trouble.
bool Director::stragglers_may_come() {
    const auto missing = [&](double until_s, double patience_s, const char* what) {
        if (until_s > to_s_ - 2 / frequency_) return false;
        if (now_s_ < to_s_ + patience_s) return true;
        note(fmt::format("{} end at {:.3f} s, {:.3f} s before the measurement", what, until_s,
                         to_s_ - until_s));
        return false;
    };
    return missing(windows_.until_s(), accelerometer_patience_s, "the accelerometer's data") ||
           (walker_.watches() && missing(walker_.until_s(), camera_patience_s, "the walker's pictures"));
}

void Director::note(const std::string& what) {
    say_(what);
    notes_.push_back(what);
}

void Director::command(const Harmonics<Voltage>& volts, int ramp_periods, bool transient, Lanes& lanes) {
    lanes.drive.post({.volts = volts,
                      .frequency = keeper_.drive().frequency,
                      .ramp_periods = ramp_periods,
                      .sequence = ++sequence_});
    if (!transient) return;
    // Until the change is known to be in force, no period counts as settled.
    awaited_ = sequence_;
    in_force_s_ = steady_from_s_ = INFINITY;
}

}  // namespace shaker

#include "daemon/director.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "drivers/errors.hpp"

namespace shaker {

namespace {
constexpr int controlled = 8;                   // harmonics
constexpr double most_samples = 1.2;            // of the nominal number a period
constexpr double accelerometer_patience_s = 8;  // its driver gives up before
constexpr double camera_patience_s = 2;
constexpr double least_repeats = 16;     // of a sample, before it is taken for frozen
constexpr double transient_periods = 1;  // after a ramp, until the suspension has followed
}  // namespace

Director::Director(const RunPlan& plan, double dac_rate_hz, const AccelerometerInfo& accelerometer, Say say)
    : plan_{plan},
      frequency_{Synthesiser::realised(plan.drive.frequency, dac_rate_hz)},
      dac_rate_hz_{dac_rate_hz},
      accelerometer_{accelerometer},
      say_{std::move(say)},
      clock_{dac_rate_hz, accelerometer.rate_hz},
      estimator_{controlled, static_cast<int>(most_samples * accelerometer.rate_hz / frequency_) + 2,
                 accelerometer.shaker_axis},
      equaliser_{harmonics(plan.drive),
                 plan.response,
                 {.harmonics = controlled, .gain = 0.7, .volts_limit = plan.volts_limit}},
      fold_{0, 1 / frequency_} {}

bool Director::step(const Take& take, Mailbox<DriveCommand>& drive) {
    const std::size_t before = plays_ + blocks_ + changes_ + tracks_;
    take_stamps(take, drive);
    if (!started_ && plays_ > 0) {
        started_ = true;
        say_(fmt::format("soft start over {} periods", plan_.soft_start));
        command(equaliser_.volts(), plan_.soft_start, drive);
    }
    take_accelerations(take, drive);
    take_tracks(take);
    advance(drive);
    return plays_ + blocks_ + changes_ + tracks_ != before;
}

void Director::take_stamps(const Take& take, Mailbox<DriveCommand>& drive) {
    for (; plays_ < take.played.size(); ++plays_) {
        const PlayTime& played = take.played[plays_];
        clock_.add(played);
        if (played.lost > 0)
            start_again(played.lost, drive);
        else
            now_s_ = static_cast<double>(played.tick.n) / dac_rate_hz_;
    }
    for (; changes_ < take.changes.size(); ++changes_) {
        const DriveChange& c = take.changes[changes_];
        const double in_force = static_cast<double>(c.first.n + c.ramp) / dac_rate_hz_;
        steady_from_s_ = in_force + transient_periods / frequency_;
        // The silence after lost time has no number: the ramp up from it is still to come.
        if (state_ == RunState::ramp && c.command.sequence == sequence_) settle_from_s_ = in_force;
        if (state_ == RunState::ramp_down) silent_s_ = in_force;
    }
}

// The DAC ran empty and stands at zero: what was measured so far is cut, the drive comes up softly once more.
void Director::start_again(std::int64_t lost, Mailbox<DriveCommand>& drive) {
    if (state_ == RunState::done) return;
    note(fmt::format("the DAC ran empty at {:.3f} s and stood still for {:.1f} ms", now_s_,
                     1e3 * static_cast<double>(lost) / dac_rate_hz_));
    if (state_ == RunState::ramp_down) {  // it is silent already
        state_ = RunState::done;
        return;
    }
    if (++restarts_ > plan_.most_restarts)
        throw DeviceError{fmt::format("the DAC ran empty {} times in one run; given up", restarts_)};
    locked_ = false;
    if (started_) command(equaliser_.volts(), plan_.soft_start, drive);
    state_ = RunState::ramp;
    settle_from_s_ = 0;
}

// A base that is driven never shows the same sample for half a period. A controller that believed it would
// raise the drive.
void Director::watch(const AccelBlock& block) {
    for (int i = 0; i < block.size; ++i) {
        const auto& counts = block.counts[static_cast<std::size_t>(i)];
        repeats_ = counts == last_counts_ ? repeats_ + 1 : 0;
        last_counts_ = counts;
    }
    const bool driving = state_ == RunState::settle || state_ == RunState::measure;
    if (driving && repeats_ >= std::max(least_repeats, 0.5 * accelerometer_.rate_hz / frequency_))
        throw DeviceError{
            fmt::format("{}: the same sample {} times in a row while the base is driven: it is frozen",
                        accelerometer_.name, repeats_ + 1)};
}

void Director::take_accelerations(const Take& take, Mailbox<DriveCommand>& drive) {
    for (; blocks_ < take.blocks.size(); ++blocks_) {
        const AccelBlock& block = take.blocks[blocks_];
        watch(block);
        clock_.add(block);
        if (!clock_.ready()) continue;
        accelerations_until_s_ = seconds(clock_.master({block.first.n + block.size}));
        for (int i = 0; i < block.size; ++i) {
            const auto a = accelerometer_.acceleration(block.counts[static_cast<std::size_t>(i)]);
            const double turns = frequency_ * seconds(clock_.master({block.first.n + i}));
            if (const auto done = estimator_.add(turns, a)) period_done(*done, drive);
        }
    }
}

// The one back arrow: an estimate of a period that lay wholly behind the last change corrects the drive.
void Director::period_done(const PeriodEstimate& estimate, Mailbox<DriveCommand>& drive) {
    const double began_s = static_cast<double>(estimate.period) / frequency_;
    const bool driving = state_ == RunState::settle || state_ == RunState::measure;
    if (!driving || began_s < steady_from_s_) return;
    // While it is measured the drive stays as it is: a change is a transient.
    if (state_ == RunState::settle) correct(estimate, drive);
    // What stays the same is told once a second.
    if (state_ == RunState::measure && began_s < told_s_ + 1) return;
    told_s_ = began_s;
    const Drive got = drive_of(estimate.along, frequency_);
    say_(fmt::format("{:7.3f} s  gamma {:.4f} m/s^2  phi {:+.3f} deg  drive {}", began_s, got.gamma,
                     got.phi * 180 / std::numbers::pi, locked_ ? "locked" : "settling"));
}

void Director::correct(const PeriodEstimate& estimate, Mailbox<DriveCommand>& drive) {
    const Equaliser::Report report = equaliser_.update(estimate.along, estimate.sd);
    locked_ = report.locked;
    reached_ = report.reached;
    if (!locked_) command(equaliser_.volts(), 1, drive);
}

void Director::take_tracks(const Take& take) {
    const auto walker =
        std::ranges::find_if(take.tracks, [](const auto& t) { return t.target.name == "walker"; });
    watches_walker_ = walker != take.tracks.end();
    if (!watches_walker_) return;
    for (; tracks_ < walker->tracks.size(); ++tracks_) {
        const Track& t = walker->tracks[tracks_];
        if (!std::isfinite(seconds(t.time))) continue;
        tracks_until_s_ = std::max(tracks_until_s_, seconds(t.time));
        if (!found(t.fix.state)) continue;
        if (const auto period = fold_.add(seconds(t.time), t.x_m, t.sd_m)) {
            drifts_.push_back(*period);
            walker_settled_ = settled_since_steady();
        }
    }
}

void Director::advance(Mailbox<DriveCommand>& drive) {
    switch (state_) {
        case RunState::ramp:
            if (settle_from_s_ > 0 && now_s_ >= settle_from_s_) {
                state_ = RunState::settle;
                say_("settling: the drive by its measured harmonics, then the walker");
            }
            break;
        case RunState::settle: {
            const bool late = now_s_ - settle_from_s_ > plan_.settle_at_most / frequency_;
            if (!(locked_ && now_s_ > steady_from_s_ && walker_settled_) && !late) break;
            if (late)
                note(fmt::format("{} had not settled after {} periods; it was measured all the same",
                                 locked_ ? "the walker" : "the drive", plan_.settle_at_most));
            if (reached_ < 1)
                note(fmt::format("the DAC's {} V reach only {:.1f} % of the asked gamma", plan_.volts_limit,
                                 100 * reached_));
            state_ = RunState::measure;
            from_s_ = std::ceil(now_s_ * frequency_) / frequency_;
            to_s_ = from_s_ + plan_.periods / frequency_;
            say_(fmt::format("measuring {} periods from {:.3f} s on", plan_.periods, from_s_));
            break;
        }
        case RunState::measure:
            if (now_s_ < to_s_ + 2 / frequency_ || stragglers_may_come()) break;
            state_ = RunState::ramp_down;
            say_("soft stop");
            command({}, plan_.soft_start, drive);
            break;
        case RunState::ramp_down:
            if (silent_s_ > 0 && now_s_ > silent_s_) state_ = RunState::done;
            break;
        case RunState::done:
            break;
    }
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
    return missing(accelerations_until_s_, accelerometer_patience_s, "the accelerometer's data") ||
           (watches_walker_ && missing(tracks_until_s_, camera_patience_s, "the walker's pictures"));
}

// Takes the drifts of whole periods since the drive has been steady, to one ten-thousandth of V / f.
bool Director::settled_since_steady() const {
    std::vector<double> since;
    double sigma = 1e-4 * plan_.drive.gamma / (two_pi * frequency_ * frequency_);
    for (const PeriodFold::Period& p : drifts_) {
        if ((p.k - 1) / frequency_ < steady_from_s_) continue;  // a drift spans two periods
        since.push_back(p.drift.value);
        sigma = std::max(sigma, p.drift.sigma);
    }
    return settled(since, sigma);
}

void Director::note(const std::string& what) {
    say_(what);
    notes_.push_back(what);
}

void Director::command(const Harmonics<Voltage>& volts, int ramp_periods, Mailbox<DriveCommand>& drive) {
    drive.post({.volts = volts,
                .frequency = plan_.drive.frequency,
                .ramp_periods = ramp_periods,
                .sequence = ++sequence_});
    // Until the change is known to be in force, no period counts as settled.
    steady_from_s_ = INFINITY;
    walker_settled_ = false;
}

}  // namespace shaker

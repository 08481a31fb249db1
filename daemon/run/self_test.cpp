#include "daemon/run/self_test.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>

#include "daemon/run/sequence.hpp"
#include "drivers/errors.hpp"
#include "drivers/time.hpp"

namespace shaker::run {

SelfTest::SelfTest(const SelfTestPlan& plan, double dac_rate_hz) : plan_{plan}, dac_rate_hz_{dac_rate_hz} {
    quiet_ = {0.2 * plan.quiet_s, plan.quiet_s};
}

void SelfTest::post(const Harmonics<Voltage>& volts, Mailbox<DriveCommand>& drive) {
    drive.post(
        {.volts = volts, .frequency = plan_.frequency, .ramp_periods = plan_.ramp, .sequence = ++sequence_});
    in_force_s_ = INFINITY;
}

void SelfTest::come_down(Mailbox<DriveCommand>& drive) {
    drive.post({.volts = {},
                .sequence = ++sequence_,
                .stop_s = std::min(plan_.ramp / plan_.frequency, longest_soft_stop_s)});
    in_force_s_ = INFINITY;
    state_ = State::ramp_down;
}

void SelfTest::leave(Mailbox<DriveCommand>& drive) {
    if (state_ == State::quiet) state_ = State::done;
    if (state_ == State::ramp || state_ == State::hold) come_down(drive);
}

bool SelfTest::step(const acquisition::Streams& streams, Mailbox<DriveCommand>& drive) {
    const bool any = plays_ != streams.played.size() || changes_ != streams.changes.size();
    for (; plays_ < streams.played.size(); ++plays_)
        if (const PlayTime& p = streams.played[plays_]; p.lost > 0)
            throw DeviceError{
                fmt::format("the DAC ran empty at {:.3f} s and was silent for {:.1f} ms: the computer is too "
                            "busy, or buffer_frames is too small",
                            counted_s(p.tick, dac_rate_hz_), 1e3 * duration_s(p.lost, dac_rate_hz_))};
    const double now_s = streams.played.empty() ? 0 : counted_s(streams.played.back().tick, dac_rate_hz_);
    if (!trip_ && !streams.trips.empty()) {
        trip_ = streams.trips.front();
        state_ = State::tripped;
        if (!std::isfinite(silent_s_)) silent_s_ = now_s + longest_soft_stop_s;
    }
    for (; changes_ < streams.changes.size(); ++changes_) {
        const DriveChange& c = streams.changes[changes_];
        if (c.stop > 0) silent_s_ = counted_s(DacTick{c.first.n + c.stop}, dac_rate_hz_);
        if (c.command.sequence == sequence_) in_force_s_ = counted_s(c.end(), dac_rate_hz_);
    }
    if (streams.played.empty()) return any;
    const double period_s = 1 / plan_.frequency;
    switch (state_) {
        case State::quiet:
            if (now_s < plan_.quiet_s + period_s) break;
            {
                Harmonics<Voltage> volts;
                volts.at(1) = plan_.volts;
                volts.at(2) = plan_.volts;
                post(volts, drive);
            }
            state_ = State::ramp;
            break;
        case State::ramp:
            if (now_s < in_force_s_) break;
            // The suspension settles within five periods.
            held_.from_s = std::ceil(in_force_s_ / period_s + 5) * period_s;
            held_.to_s = held_.from_s + plan_.hold * period_s;
            state_ = State::hold;
            break;
        case State::hold:
            if (now_s < held_.to_s + 2 * period_s) break;
            come_down(drive);
            break;
        case State::ramp_down:
            if (now_s > in_force_s_) state_ = State::done;
            break;
        case State::tripped:
            if (now_s > silent_s_) state_ = State::done;
            break;
        case State::done:
            break;
    }
    return any;
}

}  // namespace shaker::run

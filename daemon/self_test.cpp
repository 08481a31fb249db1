#include "daemon/self_test.hpp"

#include <cmath>

namespace shaker {

SelfTest::SelfTest(const SelfTestPlan& plan, double dac_rate_hz) : plan_{plan}, dac_rate_hz_{dac_rate_hz} {
    quiet_ = {0.2 * plan.quiet_s, plan.quiet_s};
}

void SelfTest::post(const Harmonics<Voltage>& volts, Mailbox<DriveCommand>& drive) {
    drive.post(
        {.volts = volts, .frequency = plan_.frequency, .ramp_periods = plan_.ramp, .sequence = ++sequence_});
    in_force_s_ = INFINITY;
}

bool SelfTest::step(const Take& take, Mailbox<DriveCommand>& drive) {
    const bool any = plays_ != take.played.size() || changes_ != take.changes.size();
    plays_ = take.played.size();
    for (; changes_ < take.changes.size(); ++changes_) {
        const DriveChange& c = take.changes[changes_];
        if (c.command.sequence == sequence_)
            in_force_s_ = static_cast<double>(c.first.n + c.ramp) / dac_rate_hz_;
    }
    if (take.played.empty()) return any;
    const double now_s = static_cast<double>(take.played.back().tick.n) / dac_rate_hz_;
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
            // Five periods for the suspension to follow.
            held_.from_s = std::ceil(in_force_s_ / period_s + 5) * period_s;
            held_.to_s = held_.from_s + plan_.hold * period_s;
            state_ = State::hold;
            break;
        case State::hold:
            if (now_s < held_.to_s + 2 * period_s) break;
            post({}, drive);
            state_ = State::ramp_down;
            break;
        case State::ramp_down:
            if (now_s > in_force_s_) state_ = State::done;
            break;
        case State::done:
            break;
    }
    return any;
}

}  // namespace shaker

#include "drivers/walker/walker.hpp"

#include <cmath>
#include <limits>
#include <stdexcept>

namespace shaker::walker {

namespace {

/// rad; extrema of v_R this close to an event belong to the event itself, where the walker leaves v_R = 0.
constexpr double departure = 1e-12;

}  // namespace

Walker::Walker(const WalkerLaw& law, double v, double phase) : law_{&law} {
    if (!(phase >= 0 && phase < 1)) throw std::invalid_argument{"a walker starts at a phase in [0, 1)"};
    if (!std::isfinite(v)) throw std::invalid_argument{"a walker starts with a finite velocity"};
    const double theta = two_pi * phase;
    const Turn z = phase == 0 ? Turn{} : turn(theta);
    const double v_R = v - law.v_base(z);
    motion_ = {v, 0};
    if (std::abs(v_R) > 4 * std::numeric_limits<double>::epsilon() * law.velocity_scale()) {
        const Contact direction = v_R > 0 ? Contact::forward : Contact::backward;
        const SlipLaw& slip = law.slip(direction);
        begin_slip(direction, theta, slip.growth(theta) * v_R - slip.k_at(theta, z), 0);
    } else if (const Contact zone = law.zone_after(theta).contact; zone == Contact::stick) {
        begin_stick(theta, law.x_base(z));
    } else {
        begin_slip(zone, theta, -law.slip(zone).k_at(theta, z), theta + departure);
    }
    now_ = {0, v, contact_};
    now_phase_ = theta;
}

void Walker::begin_stick(double phase, double x_base) noexcept {
    contact_ = Contact::stick;
    from_ = phase;
    x_base_from_ = x_base;
    const WalkerLaw::Zone& zone = law_->zone_after(phase);
    if (zone.contact != Contact::stick) {
        end_.phase = phase;  // only by rounding, at the end of a stick zone
    } else {
        end_.phase = zone.to < two_pi ? zone.to : SlipLaw::never;
    }
}

void Walker::begin_slip(Contact direction, double phase, double C, double ignore_until) noexcept {
    contact_ = direction;
    from_ = phase;
    end_ = law_->slip(direction).next_zero(phase, C, ignore_until);
}

void Walker::record(Contact from, Contact to) noexcept {
    if (event_count_ < most_events) events_[event_count_++] = {end_.phase / two_pi, from, to};
}

void Walker::release() noexcept {
    const WalkerLaw::Zone& zone = law_->zone_after(from_);
    if (zone.contact != Contact::stick) {
        record(Contact::stick, zone.contact);
        return begin_slip(zone.contact, from_, -law_->slip(zone.contact).k_at(from_), from_ + departure);
    }
    const Contact direction = law_->next(zone).contact;
    motion_ = {zone.v_base_to, motion_.x + (zone.x_base_to - x_base_from_)};
    record(Contact::stick, direction);
    begin_slip(direction, zone.to, zone.C_next, zone.to + departure);
}

void Walker::end_slip() noexcept {
    const double phase = end_.phase;
    const Contact before = contact_, after = law_->zone_after(phase).contact;
    motion_ = law_->slip(before).advance(motion_, from_, phase);
    if (after == Contact::stick) {
        record(before, after);
        motion_.v = law_->v_base(end_.at);
        return begin_stick(phase, law_->x_base(end_.at));
    }
    if (after != before) record(before, after);  // else v_R only touched 0
    begin_slip(after, phase, -law_->slip(after).k_at(phase, end_.at), phase + departure);
}

void Walker::take_event() noexcept {
    if (contact_ == Contact::stick) {
        release();
    } else {
        end_slip();
    }
}

Motion Walker::motion_at(double phase) const noexcept {
    if (contact_ != Contact::stick) return law_->slip(contact_).advance(motion_, from_, phase);
    const Turn z = turn(phase);
    return {law_->v_base(z), motion_.x + (law_->x_base(z) - x_base_from_)};
}

void Walker::forget_last_period() noexcept {
    if (!fresh_) return;
    fresh_ = false;
    event_count_ = 0;
}

double Walker::advance_period() noexcept {
    forget_last_period();
    while (end_.phase != SlipLaw::never) take_event();
    if (contact_ == Contact::stick) {
        motion_ = {law_->v_base_at_0(), motion_.x + (law_->x_base_at_0() - x_base_from_)};
    } else {
        motion_ = law_->slip(contact_).advance(motion_, from_, two_pi);
    }
    const double walked = motion_.x;
    x_before_ += walked;
    motion_.x = 0;
    ++period_;
    fresh_ = true;
    now_ = {x_before_, motion_.v, contact_};
    now_phase_ = 0;
    if (contact_ == Contact::stick) {
        begin_stick(0, law_->x_base_at_0());
    } else {
        const double v_R = motion_.v - law_->v_base_at_0();
        begin_slip(contact_, 0, v_R - law_->slip(contact_).k_at(0, Turn{}), 0);
    }
    return walked;
}

WalkerPoint Walker::advance_to(double phase) {
    const double theta = two_pi * phase;
    if (!(theta >= now_phase_ && phase <= 1)) {
        throw std::invalid_argument{"a walker can only advance to a later phase of the present period"};
    }
    forget_last_period();
    while (end_.phase <= theta) take_event();
    const Motion m = motion_at(theta);
    now_ = {x_before_ + m.x, m.v, contact_};
    now_phase_ = theta;
    return now_;
}

}  // namespace shaker::walker

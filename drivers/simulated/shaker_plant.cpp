#include "drivers/simulated/shaker_plant.hpp"

#include <algorithm>
#include <boost/math/tools/toms748_solve.hpp>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <utility>

namespace shaker::simulated {

namespace {
using std::numbers::pi;
// Per sample; more is chatter, and the contacts then stay until the end of the sample.
constexpr long most_changes = 20;
}  // namespace

ShakerPlant::ShakerPlant(const Scene& scene)
    : p_{scene.shaker}, law_{scene}, friction_{scene}, h_{1 / scene.dac_rate_hz} {
    for (std::size_t k = 0; k < 2; ++k) {
        const double wh = 2 * pi * p_.high_pass_hz[k] * h_;
        high_pass_gain_[k] = -std::expm1(-wh);
        high_pass_mean_[k] = wh > 0 ? high_pass_gain_[k] / wh : 1;
    }
    gain_growth_ = p_.gain_drift_per_min / 60 * h_;
    state_.walker_x = 1e-3 * scene.walker.start_mm;
    contacts_.base = law_.rubs() ? 0 : 1;
    contacts_.grip = friction_.standing();
    contacts_ = law_.settled(motion_, contacts_, true, true, ShakerLaw::Released::none);
    state_.slip = contacts_.slip;
    state_.held = law_.rubs() && contacts_.base == 0;
}

double ShakerPlant::amplified(double volts) noexcept {
    double y = volts;
    for (std::size_t k = 0; k < 2; ++k) {  // exact for a held input; the output is the sample's mean
        const double out = y - high_pass_[k];
        high_pass_[k] += high_pass_gain_[k] * out;
        y = out * high_pass_mean_[k];
    }
    const double gain =
        p_.amplifier_gain * gain_factor_ * (1 + gain_growth_ * static_cast<double>(samples_++));
    const double limit = p_.drive == DriveKind::voltage ? p_.amplifier_limit_v : p_.amplifier_limit_a;
    return std::clamp(gain * y, -limit, limit);
}

void ShakerPlant::move_walker(const ShakerMotion& end, double t) noexcept {
    if (!contacts_.walker) return;
    if (contacts_.slip == 0) {
        state_.walker_x += end.x - motion_.x;
        state_.walker_v = end.v;
        return;
    }
    const double a = law_.walker_acceleration(contacts_);
    state_.walker_x += t * (state_.walker_v + 0.5 * t * a);
    state_.walker_v += t * a;
}

// Advances by a whole sample if no contact changes or comes close to a change.
bool ShakerPlant::unchanged_sample() {
    const ShakerMotion end = law_.sample_later(motion_, contacts_, output_);
    const double v_R =
        state_.walker_v - motion_.v + h_ * law_.walker_acceleration(contacts_) - (end.v - motion_.v);
    const bool was_near = std::exchange(near_, is_near(law_.margins(end, v_R, contacts_)));
    if (was_near || near_) return false;
    move_walker(end, h_);
    motion_ = end;
    return true;
}

bool ShakerPlant::is_near(const std::array<double, 3>& margins) const noexcept {
    const auto grazes = law_.grazes(contacts_);
    return !(margins[0] > grazes[0] && margins[1] > grazes[1] && margins[2] > grazes[2]);
}

namespace {

// Time of the minimum of a smooth margin between 0 and `end`, by the parabola through its middle; else `end`.
template <class Margin>
double lowest(const Margin& margin, double end) {
    const double first = margin(0), middle = margin(0.5 * end), last = margin(end);
    const double bend = 2 * (first + last - 2 * middle), slope = 4 * middle - 3 * first - last;
    const double u = bend > 0 ? -slope / (2 * bend) : 1;
    return u > 0 && u < 1 ? u * end : end;
}

// The first time up to `end` at which a margin is not positive, or infinity.
template <class Margin>
double first_change(const Margin& margin, double end) {
    constexpr double never = std::numeric_limits<double>::infinity();
    double from = 0;
    if (!(margin(end) <= 0)) {
        if (margin(0) <= 0) return never;  // the contact has just started
        end = lowest(margin, end);
        if (!(margin(end) <= 0)) return never;
    } else if (margin(0) <= 0) {
        // A contact that has just started has a margin of zero: finds a time at which it is positive.
        for (from = 0.5 * end; from > 1e-9 * end && margin(from) <= 0;) from *= 0.5;
        if (margin(from) <= 0) return 0;
    }
    std::uintmax_t iterations = 60;
    return boost::math::tools::toms748_solve(
               margin, from, end, [](double a, double b) { return b - a < 1e-16; }, iterations)
        .second;
}

}  // namespace

// Advances to the first change, by at most `most` seconds; returns the time advanced.
double ShakerPlant::advance(double most, bool may_change) {
    const ShakerLaw::Series path = law_.series(motion_, contacts_, output_);
    const double v_R = contacts_.slip == 0 ? 0 : state_.walker_v - motion_.v;
    const double a_w = law_.walker_acceleration(contacts_);
    double first = most;
    std::size_t changed = 3;
    for (std::size_t i = 0; i < 3 && may_change; ++i) {
        const double t = first_change(
            [&](double at) {
                return law_.margins(path.at(at), v_R + (at * a_w - path.gain_of_v(at)), contacts_)[i];
            },
            most);
        if (t < first || (t == first && changed == 3)) first = t, changed = i;
    }
    const ShakerMotion end = path.at(first);
    move_walker(end, first);
    motion_ = end;
    if (changed < 3) {
        change(changed);
        near_ = true;
    }
    return first;
}

// Changes the contacts when a margin has become zero. contact: 0 walker, 1 slide, 2 end stop.
void ShakerPlant::change(std::size_t contact) {
    const bool rode = contacts_.slip == 0, was_held = contacts_.base == 0;
    if (contact == 0 && !rode) state_.walker_v = motion_.v;
    if (contact == 1 && !was_held) {
        motion_.v = 0;
        if (rode) state_.walker_v = 0;
    }
    if (contact == 2) contacts_.stop = contacts_.stop != 0 ? 0 : (motion_.x < 0 ? -1 : 1);
    const auto released = contact == 0 && rode       ? ShakerLaw::Released::walker
                          : contact == 1 && was_held ? ShakerLaw::Released::base
                                                     : ShakerLaw::Released::none;
    contacts_ = law_.settled(motion_, contacts_, rode || contact == 0, was_held || contact == 1, released);
    ++events_;
}

// Friction of the next sample, from the motion at its start.
void ShakerPlant::change_grip() {
    RelativeMotion m{
        .x = state_.walker_x - motion_.x, .v = state_.walker_v - motion_.v, .slip = contacts_.slip};
    if (m.slip != 0) m.a = law_.walker_acceleration(contacts_) - state_.a;
    contacts_.grip = friction_.next(m);
    near_ = near_ || is_near(law_.margins(motion_, m.v, contacts_));
}

void ShakerPlant::step(double volts) {
    if (friction_.varies() && contacts_.walker) change_grip();
    output_ = amplified(volts);
    if (p_.drive == DriveKind::current && output_ != motion_.current) {  // the force jumps
        motion_.current = output_;
        const Contacts before = contacts_;
        contacts_ =
            law_.settled(motion_, before, before.slip == 0, before.base == 0, ShakerLaw::Released::none);
        events_ += (contacts_.slip != before.slip ? 1 : 0) + (contacts_.base != before.base ? 1 : 0);
        near_ = near_ || is_near(law_.margins(motion_, state_.walker_v - motion_.v, contacts_));
    }
    if (!unchanged_sample()) {
        const long before = events_;
        for (double left = h_; left > 0;)
            left -= advance(std::min(left, law_.longest_step()), events_ - before < most_changes);
    }
    state_.current = motion_.current;
    state_.x = motion_.x;
    state_.v = motion_.v;
    state_.a = law_.base_acceleration(motion_, contacts_);
    state_.slip = contacts_.slip;
    if (!friction_.sticks()) state_.slip = state_.walker_v < state_.v ? -1 : 1;
    state_.held = law_.rubs() && contacts_.base == 0;
    state_.stop = contacts_.stop;
}

void ShakerPlant::set_walker(bool on_table) noexcept {
    if (on_table == contacts_.walker) return;
    contacts_.walker = on_table;
    contacts_.slip = 0;
    state_.walker_v = on_table ? motion_.v : 0;
    friction_.put_down(state_.walker_x - motion_.x);
    contacts_ = law_.settled(motion_, contacts_, true, contacts_.base == 0, ShakerLaw::Released::none);
    near_ = true;
}

void ShakerPlant::put_walker_back() noexcept {
    set_walker(false);
    state_.walker_x = motion_.x;
    set_walker(true);
}

std::array<double, 2> ShakerPlant::response(const Scene& scene, double frequency) {
    using namespace std::complex_literals;
    const ShakerTruth& p = scene.shaker;
    const std::complex<double> jw = 2i * pi * frequency;
    std::complex<double> chain = p.amplifier_gain;
    for (const double hz : p.high_pass_hz) chain *= jw / (jw + 2 * pi * hz);
    const std::complex<double> mechanical =  // force / velocity
        (p.moving_mass_kg + p.base_mass_kg) * jw + p.damping_nspm + p.stiffness_npm / jw;
    const std::complex<double> coil = p.resistance_ohm + jw * p.inductance_h;
    const double bl = p.force_factor_npa;
    const std::complex<double> velocity =
        p.drive == DriveKind::voltage ? bl / (coil * mechanical + bl * bl) : bl / mechanical;
    const std::complex<double> h = chain * velocity * jw;
    return {h.real(), h.imag()};
}

}  // namespace shaker::simulated

#include "drivers/simulated/shaker_law.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace shaker::simulated {

namespace {
using std::numbers::pi;
constexpr double furthest_m = 0.01;  // largest |x| for which steps are chosen
}  // namespace

ShakerLaw::ShakerLaw(const Scene& scene)
    : p_{scene.shaker},
      mass_{p_.moving_mass_kg + p_.base_mass_kg},
      walker_mass_{scene.walker.mass_kg},
      downhill_{scene.gravity * std::sin(scene.tilt_deg * pi / 180)},
      hold_{p_.static_friction_n},
      travel_{p_.stop_travel_mm > 0 ? 1e-3 * p_.stop_travel_mm : std::numeric_limits<double>::infinity()},
      stop_time_{p_.stop_damping_nspm / p_.stop_stiffness_npm},
      linear_{p_.cubic_stiffness_npm3 == 0 && p_.force_factor_falloff_pm2 == 0},
      current_drive_{p_.drive == DriveKind::current},
      sample_{1 / scene.dac_rate_hz} {
    // Bound of the system's norm in energy units: no solution grows or oscillates faster.
    const double stopped = p_.stop_travel_mm > 0 ? 1 : 0;
    const double stiffness = p_.stiffness_npm + stopped * p_.stop_stiffness_npm +
                             3 * p_.cubic_stiffness_npm3 * furthest_m * furthest_m;
    double rate = std::sqrt(stiffness / mass_) + (p_.damping_nspm + stopped * p_.stop_damping_nspm) / mass_;
    if (!current_drive_)
        rate += p_.resistance_ohm / p_.inductance_h +
                p_.force_factor_npa * (1 + p_.force_factor_falloff_pm2 * furthest_m * furthest_m) /
                    std::sqrt(p_.inductance_h * mass_);
    choose_step(rate);
    if (linear_) prepare_samples();
}

// Chooses steps and the number of terms for which the remainder is below 1e-18.
void ShakerLaw::choose_step(double rate) {
    constexpr double longest = 0.25;
    const double pieces = std::ceil(rate * sample_ / longest);
    longest_ = sample_ / std::max(1.0, pieces);
    const double step = rate * longest_;
    order_ = 2;  // of a body under a constant force
    for (double term = step; order_ + 1 < terms && term > 1e-18;)
        term *= step / static_cast<double>(++order_ - 1);
}

void ShakerLaw::prepare_samples() {
    for (const bool stop : {false, true})
        for (std::size_t mode = 0; mode < 3; ++mode) {
            const Contacts c{
                .walker = true, .slip = mode == 1 ? 0 : 1, .base = mode == 2 ? 0 : 1, .stop = stop ? 1 : 0};
            Linear& sample = samples_[mode == 2 ? 4 : mode + (stop ? 2 : 0)];
            sample.columns = {stepped({1, 0, 0}, c, 0, 0), stepped({0, 1, 0}, c, 0, 0),
                              stepped({0, 0, 1}, c, 0, 0), stepped({0, 0, 0}, c, 1, 0),
                              stepped({0, 0, 0}, c, 0, 1)};
        }
}

double ShakerLaw::mass(const Contacts& c) const noexcept {
    return mass_ + (c.walker && c.slip == 0 ? walker_mass_ : 0);
}

// Force of walker, slide and stop. A sticking walker adds the downhill part of its weight; a slipping one
// pulls the base in the direction of its slip.
double ShakerLaw::constant_force(const Contacts& c) const noexcept {
    double force = c.stop != 0 ? c.stop * p_.stop_stiffness_npm * travel_ : 0;
    if (c.walker) force += walker_mass_ * (c.slip == 0 ? downhill_ : c.slip * c.grip.kinetic(c.slip));
    return force - c.base * p_.kinetic_friction_n;
}

// Force on the base without the friction of the slide where it holds.
double ShakerLaw::free_force(const ShakerMotion& m, const Contacts& c) const noexcept {
    const double square = m.x * m.x;
    const bool stop = c.stop != 0;
    return p_.force_factor_npa * (1 - p_.force_factor_falloff_pm2 * square) * m.current -
           (p_.stiffness_npm + (stop ? p_.stop_stiffness_npm : 0) + p_.cubic_stiffness_npm3 * square) * m.x -
           (p_.damping_nspm + (stop ? p_.stop_damping_nspm : 0)) * m.v + constant_force(c);
}

double ShakerLaw::base_acceleration(const ShakerMotion& m, const Contacts& c) const noexcept {
    return rubs() && c.base == 0 ? 0 : free_force(m, c) / mass(c);
}

ShakerLaw::Series ShakerLaw::series(const ShakerMotion& m, const Contacts& c, double input) const noexcept {
    return series(m, c, input, constant_force(c));
}

// Recurrence of the coefficients; products of series are Cauchy sums.
ShakerLaw::Series ShakerLaw::series(const ShakerMotion& m, const Contacts& c, double input,
                                    double force) const noexcept {
    const double share_of_mass = rubs() && c.base == 0 ? 0 : 1 / mass(c), bl = p_.force_factor_npa;
    const double stiffness = p_.stiffness_npm + (c.stop != 0 ? p_.stop_stiffness_npm : 0);
    const double damping = p_.damping_nspm + (c.stop != 0 ? p_.stop_damping_nspm : 0);
    const double share_of_volts = current_drive_ ? 0 : 1 / p_.inductance_h;
    Series s;
    s.order = order_;
    s.current[0] = m.current;
    s.x[0] = m.x;
    s.v[0] = m.v;
    std::array<double, terms> square, factor;  // x^2, Bl(x)
    for (std::size_t k = 0; k < order_; ++k) {
        double coil = bl * s.current[k], emf = bl * s.v[k], cube = 0;
        if (!linear_) {
            square[k] = coil = emf = 0;
            for (std::size_t j = 0; j <= k; ++j) square[k] += s.x[j] * s.x[k - j];
            factor[k] = bl * ((k == 0 ? 1 : 0) - p_.force_factor_falloff_pm2 * square[k]);
            for (std::size_t j = 0; j <= k; ++j) {
                coil += factor[j] * s.current[k - j];
                emf += factor[j] * s.v[k - j];
                cube += square[j] * s.x[k - j];
            }
        }
        const double next = 1 / static_cast<double>(k + 1);
        const double push =
            coil - stiffness * s.x[k] - p_.cubic_stiffness_npm3 * cube - damping * s.v[k] + force;
        const double volts = input - p_.resistance_ohm * s.current[k] - emf;
        s.current[k + 1] = share_of_volts * volts * next;
        s.x[k + 1] = s.v[k] * next;
        s.v[k + 1] = share_of_mass * push * next;
        input = force = 0;  // constants have no higher coefficients
    }
    return s;
}

ShakerMotion ShakerLaw::Series::at(double t) const noexcept {
    ShakerMotion m{current[order], x[order], v[order]};
    for (std::size_t k = order; k-- > 0;) m = {current[k] + t * m.current, x[k] + t * m.x, v[k] + t * m.v};
    return m;
}

double ShakerLaw::Series::gain_of_v(double t) const noexcept {
    double sum = v[order];
    for (std::size_t k = order; k-- > 1;) sum = v[k] + t * sum;
    return t * sum;
}

ShakerMotion ShakerLaw::stepped(ShakerMotion m, const Contacts& c, double input,
                                double force) const noexcept {
    const auto pieces = std::lround(sample_ / longest_);
    for (long k = 0; k < pieces; ++k) m = series(m, c, input, force).at(longest_);
    return m;
}

ShakerMotion ShakerLaw::sample_later(const ShakerMotion& m, const Contacts& c, double input) const noexcept {
    const double force = constant_force(c);
    if (!linear_) return stepped(m, c, input, force);
    const bool held = rubs() && c.base == 0, rides = c.walker && c.slip == 0;
    const auto mode = (rides ? 1U : 0U) + (c.stop != 0 ? 2U : 0U);
    const std::array<ShakerMotion, 5>& by = samples_[held ? 4 : mode].columns;
    const auto sum = [&](double ShakerMotion::*part) {
        return by[0].*part * m.current + by[1].*part * m.x + by[2].*part * m.v + by[3].*part * input +
               by[4].*part * force;
    };
    return {sum(&ShakerMotion::current), sum(&ShakerMotion::x), sum(&ShakerMotion::v)};
}

std::array<double, 3> ShakerLaw::margins(const ShakerMotion& m, double v_R,
                                         const Contacts& c) const noexcept {
    std::array<double, 3> margin{1, 1, 1};
    if (c.walker && c.grip.most_hold() > 0) {
        const double needed = base_acceleration(m, c) - downhill_;
        margin[0] = c.slip != 0 ? c.slip * v_R : c.grip.hold(needed) - std::abs(needed);
    }
    if (rubs()) margin[1] = c.base != 0 ? c.base * m.v : hold_ - std::abs(free_force(m, c));
    // A stop compressed by `depth` pushes back with k (depth + tau d depth/dt) while that is positive; it
    // never returns more energy than its spring stores.
    const double side = c.stop != 0 ? c.stop : (m.x < 0 ? -1 : 1);
    const double depth = side * m.x - travel_, pressed = depth + stop_time_ * side * m.v;
    margin[2] = c.stop != 0 ? pressed : std::max(-depth, -pressed);
    return margin;
}

// Between the ends of a sample a smooth margin deviates by (its second derivative) h^2 / 8. With a time
// constant of the coil of several samples this is about a thousandth of the accelerations, and of their
// effect within a sample.
std::array<double, 3> ShakerLaw::grazes(const Contacts& c) const noexcept {
    constexpr double share = 5e-3;
    const double hold = c.grip.most_hold(), change = share * sample_ * (hold + hold_ / mass_);  // m/s
    return {c.slip != 0 ? change : share * hold, c.base != 0 ? change : share * hold_, change * sample_};
}

// True if these contacts persist when they start at relative velocities of zero.
bool ShakerLaw::possible(const ShakerMotion& m, const Contacts& c, bool together, bool still) const noexcept {
    constexpr double tie = 1e-9;  // relative to the friction: rounding where it was just overcome
    const double a = base_acceleration(m, c), force = free_force(m, c);
    if (rubs() && c.base == 0 && std::abs(force) > hold_) return false;
    if (rubs() && c.base != 0 && still && c.base * force < -tie * hold_) return false;
    if (!c.walker || c.grip.most_hold() == 0 || !together) return true;
    if (c.slip == 0) return std::abs(a - downhill_) <= c.grip.hold(a - downhill_);
    return c.slip * (walker_acceleration(c) - a) >= -tie * c.grip.most_hold();
}

Contacts ShakerLaw::settled(const ShakerMotion& m, Contacts c, bool together, bool still,
                            Released released) const noexcept {
    const bool sticks = c.grip.most_hold() > 0;
    if (c.walker && !sticks) c.slip = 1;  // never changes, for either sign
    const bool slip_open = c.walker && sticks && together, base_open = rubs() && still;
    for (const int slip : {0, 1, -1})
        for (const int base : {0, 1, -1}) {
            if (slip_open ? slip == 0 && released == Released::walker : slip != c.slip) continue;
            if (base_open ? base == 0 && released == Released::base : base != c.base) continue;
            Contacts next = c;
            next.slip = slip;
            next.base = base;
            if (possible(m, next, together, still)) return next;
        }
    return c;
}

}  // namespace shaker::simulated
